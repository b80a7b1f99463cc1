#include "arete/store/height_patch.h"

#include <algorithm>

namespace arete::store {
namespace {

struct TileRange {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // inclusive
  bool contains(int x, int y) const { return x >= x0 && x <= x1 && y >= y0 && y <= y1; }
};

// Tiles that hold posts [first, end), by cells, so that a last post on a border asks for one tile.
void tiles_over(int first, int end, int tiles, int& from, int& to) {
  from = std::clamp(first / kTileCells, 0, tiles - 1);
  to = std::clamp(std::max(first, end - 2) / kTileCells, from, tiles - 1);
}

TileRange tiles_over(const PyramidShape& shape, int level, const PostRect& r) {
  TileRange range;
  tiles_over(r.col0, r.col1, shape.tiles_x(level), range.x0, range.x1);
  tiles_over(r.row0, r.row1, shape.tiles_y(level), range.y0, range.y1);
  return range;
}

PostRect bounds_of(const PyramidShape& shape, int level, BeyondGrid beyond) {
  if (beyond == BeyondGrid::Drop)
    return {0, 0, PyramidShape::posts(shape.cols, level), PyramidShape::posts(shape.rows, level)};
  return {0, 0, shape.tiles_x(level) * kTileCells + 1, shape.tiles_y(level) * kTileCells + 1};
}

PostRect intersect(const PostRect& a, const PostRect& b) {
  return {std::max(a.col0, b.col0), std::max(a.row0, b.row0), std::min(a.col1, b.col1),
          std::min(a.row1, b.row1)};
}

}  // namespace

void HeightPatch::load(const PyramidShape& shape, int level, const PostRect& rect,
                       BeyondGrid beyond, const TileReader& read) {
  rect_ = rect;
  const std::size_t posts = index(rect.row1, rect.col0);
  counts_.assign(posts, kAbsent);
  valid_.assign(posts, 0);
  const PostRect bounds = intersect(rect, bounds_of(shape, level, beyond));
  if (bounds.empty()) return;
  const auto copy_tile = [&](int x, int y) {
    const TileId id{static_cast<std::uint32_t>(level), static_cast<std::uint32_t>(x),
                    static_cast<std::uint32_t>(y)};
    const HeightTile* tile = read(id);
    if (tile != nullptr) copy(*tile, id, bounds);
    return tile != nullptr;
  };
  const TileRange own = tiles_over(shape, level, bounds);
  bool all = true;
  for (int y = own.y0; y <= own.y1; ++y)
    for (int x = own.x0; x <= own.x1; ++x) all = copy_tile(x, y) && all;
  if (all) return;
  // Border posts of an absent tile may belong to a stored one around the rectangle.
  const TileRange around{std::max(own.x0 - 1, 0), std::max(own.y0 - 1, 0),
                         std::min(own.x1 + 1, shape.tiles_x(level) - 1),
                         std::min(own.y1 + 1, shape.tiles_y(level) - 1)};
  for (int y = around.y0; y <= around.y1; ++y)
    for (int x = around.x0; x <= around.x1; ++x)
      if (!own.contains(x, y)) copy_tile(x, y);
}

void HeightPatch::copy(const HeightTile& tile, TileId id, const PostRect& bounds) {
  const int col0 = static_cast<int>(id.x) * kTileCells;
  const int row0 = static_cast<int>(id.y) * kTileCells;
  const PostRect part = intersect(bounds, {col0, row0, col0 + kTilePosts, row0 + kTilePosts});
  if (part.empty()) return;
  const int width = part.col1 - part.col0;
  for (int r = part.row0; r < part.row1; ++r) {
    const auto from = static_cast<std::ptrdiff_t>((r - row0) * kTilePosts + part.col0 - col0);
    const auto to = static_cast<std::ptrdiff_t>(index(r, part.col0));
    std::copy_n(tile.counts.begin() + from, width, counts_.begin() + to);
    if (tile.valid.empty())
      std::fill_n(valid_.begin() + to, width, std::uint8_t{1});
    else
      std::copy_n(tile.valid.begin() + from, width, valid_.begin() + to);
  }
}

}  // namespace arete::store
