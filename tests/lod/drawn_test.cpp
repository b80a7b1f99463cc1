// Every engine through OpenGL: the vertex stage is `flatten`, and the picture is the rasterised
// `flatten`.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/lod/engine.h"
#include "arete/mesh/surface.h"
#include "arete/proof/rasteriser.h"
#include "arete/render/headless.h"
#include "arete/render/renderer.h"

#include "lod/built_terrain.h"
#include "lod/variants.h"

namespace arete::lod {
namespace {

class Drawn : public testing::TestWithParam<Variant> {
 protected:
  void SetUp() override {
    try {
      context_.emplace();
    } catch (const Error& error) {
      GTEST_SKIP() << "no OpenGL here: " << error.what();
    }
  }

  const BuiltTerrain terrain_{rough_dem(257, 193, 1, 0.1), {{"patch", "17"}}};
  std::unique_ptr<store::Terrain> opened_ = terrain_.open();
  std::unique_ptr<Engine> engine_ = GetParam().open(*opened_, "17");
  std::optional<render::HeadlessContext> context_;
};

View view_of(int k) {
  return make_view({.eye = {900.0 + 900 * k, -3000.0 + 300 * k, 1400},
                    .yaw = 0.7 * k,
                    .pitch = -0.4,
                    .near_m = 1},
                   320, 240);
}

render::Land land_of(const BuiltTerrain& terrain) {
  render::Land land;
  land.world_from_post = terrain.dem().georef().world_from_post;
  land.cols = terrain.dem().cols();
  land.rows = terrain.dem().rows();
  land.z_max = 1000;
  return land;
}

TEST_P(Drawn, VertexStageEqualsFlatten) {
  render::Renderer renderer(land_of(terrain_));
  DrawList list;
  for (int k = 0; k < 5; ++k) {
    engine_->refine(view_of(k), {.tolerance_px = 2}, list);
    const std::vector<float> drawn = renderer.vertex_stage(view_of(k), list, *engine_);
    std::size_t i = 0;
    for (const DrawBatch& batch : list.batches) {
      const auto vertices = batch.vertices == kOwnBlock ? std::span<const Vertex>(list.vertices)
                                                        : engine_->vertices(batch.vertices);
      for (const Vertex& v : vertices) {
        const float z = morphed_z(v, batch.factor);  // what mesh::flatten applies
        ASSERT_NEAR(drawn[i + 2], z, 1e-6 * std::max(1.0F, std::abs(z)));
        i += 3;
      }
    }
    EXPECT_EQ(i, drawn.size());
  }
}

// Depths agree but along silhouettes, where a pixel's centre falls on another triangle (CONVENTIONS
// I10).
TEST_P(Drawn, PictureEqualsTheRasterisedSurface) {
  render::Renderer renderer(land_of(terrain_));
  DrawList list;
  mesh::Surface surface;
  for (int k = 0; k < 4; ++k) {
    const View view = view_of(k);
    engine_->refine(view, {.tolerance_px = 2}, list);
    mesh::flatten(list, *engine_, surface);
    render::Frame frame(view.viewport_width, view.viewport_height);
    render::Style style;
    style.shading = render::Shading::Key;
    style.mask = false;
    const auto off = [&](const render::Style& drawn_style) {
      renderer.draw(view, list, *engine_, drawn_style, frame);
      const auto depth = frame.read_depth();
      const auto expected = proof::rasterise(surface, land_of(terrain_).world_from_post, view, {});
      int count = 0;
      for (std::size_t i = 0; i < depth.size(); ++i) {
        if (std::abs(depth[i] - expected.depth[i]) > 0.02 * std::max(depth[i], expected.depth[i]))
          ++count;
      }
      return count;
    };
    const int pixels = view.viewport_width * view.viewport_height;
    EXPECT_LE(off(style), pixels / 200);
    style.morph = false;  // the control: another surface makes another picture
    const bool moves = std::ranges::any_of(list.batches, [](const DrawBatch& batch) {
      return std::ranges::count(batch.factor, 0.0F) != kFactorCount;
    });
    if (moves) {
      EXPECT_GT(off(style), 0);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Drawn, testing::ValuesIn(variants()),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace arete::lod
