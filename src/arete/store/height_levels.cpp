#include "arete/store/height_levels.h"

#include <algorithm>

#include "arete/store/height_codec.h"

namespace arete::store {
namespace {

// Coarse tiles made from one patch of the finer level.
constexpr int kTilesAPatch = 16;

// A tile from the posts of the finer level that it lies on; the patch repeats the grid's edge.
class Subsampler {
 public:
  Subsampler(const PyramidShape& shape, TileId id, const HeightPatch& fine, const FillGrid* grid)
      : shape_(shape), id_(id), fine_(fine), grid_(grid) {}

  // False when no post of the tile is valid.
  bool take(HeightTile& tile) const {
    tile.counts.resize(kTilePostCount);
    tile.valid.resize(kTilePostCount);
    for (int r = 0; r < kTilePosts; ++r) take_row(r, tile);
    const auto valid = std::ranges::count(tile.valid, 1);
    if (valid == static_cast<std::ptrdiff_t>(kTilePostCount)) tile.valid.clear();
    return valid > 0;
  }

 private:
  // Beyond the patch's end: its last post, which is the grid's last, but not valid.
  void take_row(int r, HeightTile& tile) const {
    const int row = 2 * (static_cast<int>(id_.y) * kTileCells + r);
    const int col0 = 2 * static_cast<int>(id_.x) * kTileCells;
    const PostRect& rect = fine_.rect();
    const int from = std::min(row, rect.row1 - 1);
    const std::int32_t* counts = fine_.counts(from, col0);
    const std::uint8_t* valid = fine_.valid(from, col0);
    for (int c = 0; c < kTilePosts; ++c) {
      const int col = col0 + 2 * c;
      const int at = std::min(col, rect.col1 - 1) - col0;
      const auto i = static_cast<std::size_t>(r * kTilePosts + c);
      tile.valid[i] = row < rect.row1 && col < rect.col1 ? valid[at] : std::uint8_t{0};
      tile.counts[i] = counts[at] != kAbsent ? counts[at] : filled(col, row);
    }
  }

  std::int32_t filled(int col, int row) const {
    const auto level0 = [&](std::int64_t post, int posts) {
      return static_cast<int>(std::min<std::int64_t>(post << (id_.level - 1), posts - 1));
    };
    return grid_ != nullptr ? grid_->at({level0(col, shape_.cols), level0(row, shape_.rows)}) : 0;
  }

  const PyramidShape& shape_;
  TileId id_;
  const HeightPatch& fine_;
  const FillGrid* grid_;
};

}  // namespace

void store_level_row(const PyramidShape& shape, TileId id, const TileReader& finer,
                     const FillGrid* grid, UnitWriter& unit) {
  const int level = static_cast<int>(id.level);
  const int tiles = shape.tiles_x(level);
  constexpr int kSpan = 2 * kTileCells;
  const int col_end = shape.tiles_x(level - 1) * kTileCells + 1;
  const int row_end = shape.tiles_y(level - 1) * kTileCells + 1;
  const int row0 = static_cast<int>(id.y) * kSpan;
  thread_local HeightPatch fine;
  thread_local HeightTile tile;
  thread_local std::vector<std::byte> raw;
  for (int x0 = 0; x0 < tiles; x0 += kTilesAPatch) {
    const int x1 = std::min(x0 + kTilesAPatch, tiles);
    fine.load(
        shape, level - 1,
        {x0 * kSpan, row0, std::min(x1 * kSpan + 1, col_end), std::min(row0 + kSpan + 1, row_end)},
        BeyondGrid::Repeat, finer);
    for (int x = x0; x < x1; ++x) {
      id.x = static_cast<std::uint32_t>(x);
      if (!Subsampler(shape, id, fine, grid).take(tile)) continue;
      encode_tile(tile.counts, tile.valid, raw);
      unit.add(id.key(), raw);
    }
  }
}

}  // namespace arete::store
