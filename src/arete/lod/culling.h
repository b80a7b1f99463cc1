#pragma once

#include <array>

#include <glm/glm.hpp>

#include "arete/core/georef.h"
#include "arete/core/post.h"
#include "arete/core/view.h"

namespace arete::lod {

/// The first two of Wagner's three culling stages ("Optimizations" in [Wagner2003]); the third, a
/// potentially visible set, needs its own segment.
class Culling {
 public:
  /// `box_min`, `box_max`: the whole terrain, metres.
  Culling(const View& view, const Affine2& world_from_post, glm::dvec3 box_min, glm::dvec3 box_max);

  /// Stage 1: posts outside this rectangle lie outside the frustum's projection on the ground.
  PostRect ground_rect() const { return rect_; }
  /// Stage 2: may the box touch the frustum?
  bool may_see_box(glm::dvec3 lo, glm::dvec3 hi) const { return may_see(planes_, lo, hi); }

 private:
  std::array<glm::dvec4, 5> planes_;
  PostRect rect_;
};

}  // namespace arete::lod
