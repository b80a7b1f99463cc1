#pragma once

#include <cmath>
#include <limits>

#include "arete/mesh/post_projection.h"
#include "arete/proof/reference.h"

namespace arete::proof {

/// Calls body(post, index into PostHeights) for every post of the tile that counts, row by row.
template <typename Body>
void for_each_post(const Reference& reference, int tile, const Body& body) {
  const PostRect rect = reference.posts_of(tile);
  const bool check_each = !reference.all_valid_count(tile);
  for (int r = rect.row0; r < rect.row1; ++r) {
    const std::span<const float> truth = reference.dem().row(r);
    auto i = static_cast<std::size_t>((r - rect.row0) * Reference::kTilePosts);
    for (int c = rect.col0; c < rect.col1; ++c, ++i) {
      if (std::isnan(truth[static_cast<std::size_t>(c)])) continue;
      if (check_each && !reference.counts({c, r})) continue;
      body(Post{c, r}, i);
    }
  }
}

/// Projects posts and vertical displacements of them.
class ScreenShift {
 public:
  ScreenShift(const View& view, const Affine2& world_from_post)
      : projection_(view, world_from_post),
        scale_x_(view.viewport_width / 2.0),
        scale_y_(view.viewport_height / 2.0) {}

  /// Clip coordinates x, y, w.
  glm::dvec3 clip(Post p, double z) const { return projection_.clip(p.col, p.row, z); }
  bool inside(glm::dvec3 clip) const { return projection_.inside(clip); }
  glm::dvec3 raised(glm::dvec3 clip, double dz) const { return clip + dz * projection_.per_metre; }

  /// Squared distance in pixels between the image of a point with clip coordinates `c` and that of
  /// the point dz metres above it; infinite when either lies before the near plane.
  double squared_px(glm::dvec3 c, double dz) const {
    const glm::dvec3& up = projection_.per_metre;
    const double w = c.z + dz * up.z;
    if (!(w >= projection_.near_m && c.z >= projection_.near_m)) {
      return std::numeric_limits<double>::infinity();
    }
    // (x + dz ux) / (w + dz uw) - x / w over one denominator: nothing cancels.
    const double f = dz / (w * c.z);
    const double px = scale_x_ * f * (up.x * c.z - c.x * up.z);
    const double py = scale_y_ * f * (up.y * c.z - c.y * up.z);
    return px * px + py * py;
  }

 private:
  mesh::PostProjection projection_;
  double scale_x_, scale_y_;
};

}  // namespace arete::proof
