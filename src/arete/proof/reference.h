#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "arete/core/heightfield.h"
#include "arete/core/view.h"

namespace arete::proof {

/// The full-resolution terrain as the checks read it, in square tiles of posts. Posts count when
/// they have data and touch a drawable cell.
/// Lifetime: the heightfield must outlive it. Thread contract: immutable.
class Reference {
 public:
  static constexpr int kTilePosts = 64;  ///< posts a tile side

  /// Cost: reads every post once.
  Reference(const Heightfield& dem, int threads);

  const Heightfield& dem() const { return dem_; }
  const Affine2& world_from_post() const { return world_from_post_; }
  bool counts(Post p) const;

  int tile_cols() const { return tile_cols_; }
  int tile_rows() const { return tile_rows_; }
  int tiles() const { return tile_cols_ * tile_rows_; }
  /// The tile's posts, clipped to the grid.
  PostRect posts_of(int tile) const;
  /// Heights of row r of the tile; NaN for posts that do not count or lie outside the grid.
  void read_row(int tile, int r, std::array<double, kTilePosts>& z) const;
  /// Tiles whose counted posts may be seen, ascending. Never leaves out one that is.
  std::vector<int> visible_tiles(const View& view) const;
  /// Tiles with counted posts, ascending.
  std::vector<int> counted_tiles() const;

 private:
  struct Tile {
    float lo, hi;  // metres over counted posts; lo > hi without any
    bool stray;    // has a post with data that touches no drawable cell
  };
  Tile scan(int tile) const;

  const Heightfield& dem_;
  Affine2 world_from_post_;
  int tile_cols_, tile_rows_;
  std::vector<Tile> tiles_;
};

}  // namespace arete::proof
