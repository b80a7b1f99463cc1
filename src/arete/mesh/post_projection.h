#pragma once

#include <cmath>

#include <glm/glm.hpp>

#include "arete/core/georef.h"
#include "arete/core/view.h"

namespace arete::mesh {

/// Clip coordinates (x, y, w) of posts: affine in column, row and height, so that rows of posts
/// are projected with three additions each.
struct PostProjection {
  glm::dvec3 origin, per_col, per_row, per_metre;
  double near_m;  ///< metres

  PostProjection(const View& view, const Affine2& world_from_post);

  glm::dvec3 clip(double col, double row, double z) const {
    return origin + col * per_col + row * per_row + z * per_metre;
  }
  /// In the viewport, its border included, and not before the near plane; false for NaN.
  bool inside(glm::dvec3 c) const {
    return c.z >= near_m && std::abs(c.x) <= c.z && std::abs(c.y) <= c.z;
  }
};

}  // namespace arete::mesh
