#pragma once

#include <algorithm>
#include <cstdint>

#include "arete/core/tile_id.h"
#include "arete/store/terrain.h"

namespace arete::store {

/// The tiles of the height pyramid over a grid of cols x rows posts.
/// Post i of level L is the level-0 post min(i << L, last).
struct PyramidShape {
  int cols = 1, rows = 1;

  static int tiles(int posts, int level) {
    const std::int64_t cells = std::int64_t{kTileCells} << level;
    return static_cast<int>(std::max<std::int64_t>(1, (posts - 1 + cells - 1) / cells));
  }
  int tiles_x(int level) const { return tiles(cols, level); }
  int tiles_y(int level) const { return tiles(rows, level); }
  int levels() const {
    int n = 1;
    while (tiles_x(n - 1) > 1 || tiles_y(n - 1) > 1) ++n;
    return n;
  }
  bool contains(TileId id) const {
    return id.level < static_cast<std::uint32_t>(levels()) &&
           id.x < static_cast<std::uint32_t>(tiles_x(static_cast<int>(id.level))) &&
           id.y < static_cast<std::uint32_t>(tiles_y(static_cast<int>(id.level)));
  }
  /// Posts of a level within the grid.
  static int posts(int level0_posts, int level) { return ((level0_posts - 1) >> level) + 1; }
};

}  // namespace arete::store
