#include "arete/store/height_band.h"

#include <algorithm>

namespace arete::store {
namespace {

// Copies row `from` of the tile to row `to` of the band; border columns of stored tiles agree.
void copy_row(const HeightTile& tile, int x, int from, int to, HeightBand& band) {
  const auto source = static_cast<std::ptrdiff_t>(from) * kTilePosts;
  const auto target = static_cast<std::ptrdiff_t>(band.index(to, x * kTileCells));
  std::copy_n(tile.counts.begin() + source, kTilePosts, band.counts.begin() + target);
  if (tile.valid.empty())
    std::fill_n(band.valid.begin() + target, kTilePosts, std::uint8_t{1});
  else
    std::copy_n(tile.valid.begin() + source, kTilePosts, band.valid.begin() + target);
}

bool is_stored(const HeightBand& band, int x) {
  return band.stored[static_cast<std::size_t>(x)] != 0;
}

// Where tile x is absent its border rows may still belong to a stored tile of the row at `y`.
void borrow_row(TileId neighbour, int from, int to, const TileReader& read, HeightBand& band) {
  thread_local HeightTile tile;
  for (int x = 0; x < static_cast<int>(band.stored.size()); ++x) {
    neighbour.x = static_cast<std::uint32_t>(x);
    if (!is_stored(band, x) && read(neighbour, tile)) copy_row(tile, x, from, to, band);
  }
}

}  // namespace

void load_band(const PyramidShape& shape, TileId first, const TileReader& read, HeightBand& band) {
  const int level = static_cast<int>(first.level);
  const int tiles = shape.tiles_x(level);
  band.width = tiles * kTileCells + 1;
  const std::size_t posts = static_cast<std::size_t>(band.width) * kTilePosts;
  band.counts.resize(posts);
  band.valid.resize(posts);
  band.stored.assign(static_cast<std::size_t>(tiles), 0);
  std::fill(band.counts.begin(), band.counts.end(), kAbsent);
  std::fill(band.valid.begin(), band.valid.end(), std::uint8_t{0});
  thread_local HeightTile tile;
  const auto tile_rows = static_cast<std::uint32_t>(shape.tiles_y(level));
  for (int x = 0; x < tiles; ++x) {
    if (!read({first.level, static_cast<std::uint32_t>(x), first.y}, tile)) continue;
    band.stored[static_cast<std::size_t>(x)] = 1;
    for (int r = 0; r < kTilePosts; ++r) copy_row(tile, x, r, r, band);
  }
  if (std::ranges::count(band.stored, 1) == tiles) return;
  if (first.y > 0) borrow_row({first.level, 0, first.y - 1}, kTileCells, 0, read, band);
  if (first.y + 1 < tile_rows) borrow_row({first.level, 0, first.y + 1}, 0, kTileCells, read, band);
}

}  // namespace arete::store
