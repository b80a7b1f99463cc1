#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "arete/core/view.h"
#include "arete/mesh/post_projection.h"
#include "arete/proof/reference.h"

namespace arete::proof {

/// One value a post of a tile's row. All loops over rows run over all kTilePosts values, without
/// branches, so that compilers turn them into vector code.
using RowValues = std::array<double, Reference::kTilePosts>;

/// A tile's row of posts.
struct PostRow {
  Post first;
  std::size_t offset = 0;  ///< of the row in PostHeights
  RowValues true_z;        ///< metres; NaN for posts that do not count or lie outside the grid
};

/// Calls body(row) for each row of the tile.
template <typename Body>
void for_each_row(const Reference& reference, int tile, const Body& body) {
  const PostRect rect = reference.posts_of(tile);
  PostRow row;
  for (int r = rect.row0; r < rect.row1; ++r) {
    row.first = {rect.col0, r};
    row.offset = static_cast<std::size_t>(r - rect.row0) * Reference::kTilePosts;
    reference.read_row(tile, r, row.true_z);
    body(row);
  }
}

/// Vertical displacements of posts, seen by a camera.
class ScreenShift {
 public:
  ScreenShift(const View& view, const Affine2& world_from_post)
      : projection_(view, world_from_post),
        scale_x_(view.viewport_width / 2.0),
        scale_y_(view.viewport_height / 2.0) {}

  /// Squared distance in pixels between the images of the posts at heights `from` and `to`, the
  /// row's first post being `first`. Infinite when either lies before the near plane, NaN when a
  /// height is. Requires: kTilePosts heights each.
  void squared_px(Post first, const double* from, const double* to, RowValues& out) const;

  /// Sets values to -1 where the post at its height is not in the viewport beyond the near plane.
  void drop_unseen(Post first, const RowValues& z, RowValues& values) const;

 private:
  mesh::PostProjection projection_;
  double scale_x_, scale_y_;
};

}  // namespace arete::proof
