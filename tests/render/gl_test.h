#pragma once

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "arete/core/draw_list.h"
#include "arete/core/view.h"
#include "arete/render/renderer.h"

namespace arete::render {

/// Gives a test an OpenGL context, one for the whole program; skips it where there is none.
class GlTest : public ::testing::Test {
 protected:
  void SetUp() override;
};

using Picture = std::vector<std::uint8_t>;

/// One frame of a fresh size x size target.
Picture shoot(Renderer& renderer, const View& view, const DrawList& list, const BlockSource& blocks,
              const Style& style);

/// Pixels of `a` that differ from `b` by more than `tolerance` in any channel.
int different_pixels(const Picture& a, const Picture& b, int tolerance = 0);

}  // namespace arete::render
