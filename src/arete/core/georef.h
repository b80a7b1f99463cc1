#pragma once

#include <array>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "arete/core/post.h"

namespace arete {

/// Row-major 2x3 affine: (x, y) = (m[0] col + m[1] row + m[2], m[3] col + m[4] row + m[5]).
struct Affine2 {
  std::array<double, 6> m{1, 0, 0, 0, -1, 0};
  glm::dvec2 apply(double col, double row) const {
    return {m[0] * col + m[1] * row + m[2], m[3] * col + m[4] * row + m[5]};
  }
  /// Solves apply(col, row) = p. Requires: a determinant other than 0.
  glm::dvec2 inverse(glm::dvec2 p) const;
  double determinant() const { return m[0] * m[4] - m[1] * m[3]; }
  friend bool operator==(const Affine2&, const Affine2&) = default;
};

/// Where a grid lies. World: metres, x east, y north, z up, post (0,0) at the origin.
struct Georef {
  Affine2 world_from_post;         ///< metres; m[2] = m[5] = 0
  Affine2 crs_from_post;           ///< in CRS units (degrees for geographic grids)
  std::string crs;                 ///< WKT; empty when the source names none
  std::string crs_name;            ///< short name for people, e.g. "WGS 84 (EPSG:4326)"
  std::vector<std::string> notes;  ///< what was assumed while reading, one sentence each
};

}  // namespace arete
