#include "arete/store/height_levels.h"

#include <algorithm>

#include "arete/store/height_codec.h"

namespace arete::store {
namespace {

constexpr int kHalf = kTileCells / 2;

struct CoarseRow {
  const PyramidShape& shape;
  TileId id;  // x unused
  HeightBand band;

  // Takes every other post of row `from` of the finer band; beyond its end the last one, invalid.
  void take_row(const HeightBand& fine, int from, int to, const FillGrid* grid) {
    const std::int32_t* counts = fine.row(from);
    const std::uint8_t* valid = fine.valid_row(from);
    for (int c = 0; c < band.width; ++c) {
      const int at = std::min(2 * c, fine.width - 1);
      const std::size_t i = band.index(to, c);
      band.valid[i] = 2 * c < fine.width ? valid[at] : std::uint8_t{0};
      band.counts[i] = counts[at] != kAbsent ? counts[at] : filled(c, to, grid);
    }
  }

  void repeat_row(int from, int to) {
    const auto width = static_cast<std::ptrdiff_t>(band.width);
    const auto source = static_cast<std::ptrdiff_t>(band.index(from, 0));
    const auto target = static_cast<std::ptrdiff_t>(band.index(to, 0));
    std::copy_n(band.counts.begin() + source, width, band.counts.begin() + target);
    std::fill_n(band.valid.begin() + target, width, std::uint8_t{0});
  }

  std::int32_t filled(int c, int r, const FillGrid* grid) const {
    const auto level0 = [&](std::int64_t post, int posts) {
      return static_cast<int>(std::min<std::int64_t>(post << id.level, posts - 1));
    };
    const std::int64_t row = std::int64_t{id.y} * kTileCells + r;
    return grid != nullptr ? grid->at({level0(c, shape.cols), level0(row, shape.rows)}) : 0;
  }
};

bool cut_tile(const HeightBand& band, int x, HeightTile& tile) {
  tile.counts.resize(kTilePostCount);
  tile.valid.resize(kTilePostCount);
  for (int r = 0; r < kTilePosts; ++r) {
    const auto from = static_cast<std::ptrdiff_t>(band.index(r, x * kTileCells));
    const auto to = static_cast<std::ptrdiff_t>(r) * kTilePosts;
    std::copy_n(band.counts.begin() + from, kTilePosts, tile.counts.begin() + to);
    std::copy_n(band.valid.begin() + from, kTilePosts, tile.valid.begin() + to);
  }
  const auto valid = std::ranges::count(tile.valid, 1);
  if (valid == static_cast<std::ptrdiff_t>(kTilePostCount)) tile.valid.clear();
  return valid > 0;
}

}  // namespace

void store_level_row(const PyramidShape& shape, TileId id, const TileReader& finer,
                     const FillGrid* grid, UnitWriter& unit) {
  const int tiles = shape.tiles_x(static_cast<int>(id.level));
  CoarseRow coarse{shape, id, {}};
  coarse.band.width = tiles * kTileCells + 1;
  coarse.band.counts.resize(coarse.band.index(kTilePosts, 0));
  coarse.band.valid.resize(coarse.band.index(kTilePosts, 0));
  thread_local HeightBand fine;
  const auto fine_rows = static_cast<std::uint32_t>(shape.tiles_y(static_cast<int>(id.level) - 1));
  for (std::uint32_t half = 0; half < 2; ++half) {
    const int first = static_cast<int>(half) * kHalf;
    if (2 * id.y + half < fine_rows) {
      load_band(shape, {id.level - 1, 0, 2 * id.y + half}, finer, fine);
      for (int r = 0; r <= kHalf; ++r) coarse.take_row(fine, 2 * r, first + r, grid);
    } else {
      for (int r = first + 1; r <= first + kHalf; ++r) coarse.repeat_row(first, r);
    }
  }
  HeightTile tile;
  std::vector<std::byte> raw;
  for (int x = 0; x < tiles; ++x) {
    if (!cut_tile(coarse.band, x, tile)) continue;
    encode_tile(tile.counts, tile.valid, raw);
    unit.add(TileId{id.level, static_cast<std::uint32_t>(x), id.y}.key(), raw);
  }
}

}  // namespace arete::store
