#pragma once

#include <cstdint>
#include <vector>

#include "arete/core/post.h"
#include "arete/store/height_patch.h"
#include "arete/store/terrain.h"

namespace arete::lod::bintree {

/// A rectangle of level-0 posts as exact numbers; NaN where the post belongs to no drawable cell.
class PostRows {
 public:
  /// `rect` is cut to the grid. Keeps its memory. Throws: Corrupt when a tile is damaged.
  void load(const store::Terrain& terrain, const PostRect& rect);
  const PostRect& rect() const { return rect_; }
  /// Lattice counts of row `row`, from column rect().col0 on.
  const double* row(int row) const {
    return z_.data() + static_cast<std::ptrdiff_t>(row - rect_.row0) * (rect_.col1 - rect_.col0);
  }

 private:
  void drop_undrawable(int row, double* z);

  PostRect rect_;
  store::HeightPatch patch_;
  std::vector<double> z_;
  std::vector<std::uint8_t> above_, below_;  ///< drawable cells over and under a row
};

/// Counts of the posts at multiples of 2^level, any of them, also beyond the grid, where they are
/// those of its edge: what a vertex there is drawn at. Row-major over `rect`, in posts of the
/// level. A post that only absent tiles hold has the count that any other level's tile gives it,
/// else that of the middle of the height range.
void load_lattice(const store::Terrain& terrain, int level, const PostRect& rect,
                  std::vector<std::int32_t>& counts);

/// Throws: Corrupt when a tile was found damaged.
void require_undamaged(const store::Terrain& terrain);

}  // namespace arete::lod::bintree
