#include "arete/store/band_import.h"

#include <algorithm>

#include "arete/store/bytes.h"
#include "arete/store/height_codec.h"
#include "arete/store/height_patch.h"

namespace arete::store {
namespace {

template <typename Io, typename Summary>
void summary_fields(Io& io, Summary& s) {
  io(s.stats.valid);
  io(s.stats.count_min);
  io(s.stats.count_max);
  io(s.stats.max_error_m);
  io(s.stats.z_abs_max);
  io(s.drawable_cells);
  io(s.has_holes);
}

// Rows and columns of posts that tile t covers within the grid, of `posts` in all.
int posts_in_grid(int posts, int t) {
  return std::min(kTilePosts, posts - t * kTileCells);
}

std::span<const std::int32_t> band_row(const SourceBand& band, int cols, int r) {
  const auto n = static_cast<std::size_t>(cols);
  return std::span(band.counts).subspan(static_cast<std::size_t>(r) * n, n);
}

bool has_holes(const SourceBand& band, int cols) {
  const auto n = static_cast<std::size_t>(cols) * static_cast<std::size_t>(band.rows);
  std::int32_t least = 0;
  for (const std::int32_t c : std::span(band.counts).first(n)) least = c < least ? c : least;
  return least == kAbsent;
}

// Repeats the last column and row of the grid over the posts beyond it.
template <typename T>
void repeat_edges(int cols, int rows, std::vector<T>& posts) {
  for (int r = 0; r < rows && cols < kTilePosts; ++r) {
    const auto row = posts.begin() + static_cast<std::ptrdiff_t>(r) * kTilePosts;
    std::fill(row + cols, row + kTilePosts, row[cols - 1]);
  }
  for (int r = rows; r < kTilePosts; ++r) {
    const auto row = posts.begin() + static_cast<std::ptrdiff_t>(r) * kTilePosts;
    std::copy_n(row - kTilePosts, kTilePosts, row);
  }
}

struct Extent {
  int cols = 0, rows = 0;  // posts of the tile within the grid
};

Extent extent_of(const PyramidShape& shape, int x, int y) {
  return {posts_in_grid(shape.cols, x), posts_in_grid(shape.rows, y)};
}

// Copies the tile's posts; validity is set where the tile has a post without data or beyond the
// grid.
void cut_tile(const SourceBand& band, int cols, int x, Extent extent, HeightTile& tile) {
  tile.counts.resize(kTilePostCount);
  for (int r = 0; r < extent.rows; ++r) {
    const auto from = band_row(band, cols, r).subspan(static_cast<std::size_t>(x) * kTileCells);
    std::copy_n(from.begin(), extent.cols,
                tile.counts.begin() + static_cast<std::ptrdiff_t>(r) * kTilePosts);
  }
}

void mark_valid(Extent extent, HeightTile& tile) {
  tile.valid.assign(kTilePostCount, 0);
  for (int r = 0; r < extent.rows; ++r)
    for (int c = 0; c < extent.cols; ++c) {
      const auto i = static_cast<std::size_t>(r) * kTilePosts + static_cast<std::size_t>(c);
      tile.valid[i] = tile.counts[i] != kAbsent ? 1 : 0;
    }
}

std::uint64_t count_drawable(const HeightTile& tile) {
  if (tile.valid.empty()) return std::uint64_t{kTileCells} * kTileCells;
  std::uint64_t cells = 0;
  for (std::size_t r = 0; r < kTileCells; ++r) {
    const std::uint8_t* north = &tile.valid[r * kTilePosts];
    const std::uint8_t* south = north + kTilePosts;
    for (std::size_t c = 0; c < kTileCells; ++c)
      cells += north[c] & north[c + 1] & south[c] & south[c + 1];
  }
  return cells;
}

// The nearest value before it in row order, so that the residuals stay small.
void patch_holes(std::vector<std::int32_t>& counts) {
  const auto first = std::ranges::find_if(counts, [](std::int32_t c) { return c != kAbsent; });
  std::int32_t last = first == counts.end() ? 0 : *first;
  for (std::int32_t& c : counts) {
    if (c == kAbsent) c = last;
    last = c;
  }
}

std::vector<FillGrid::Cell> sum_cells(const SourceBand& band, const PyramidShape& shape,
                                      int cell_posts) {
  const auto n = static_cast<std::size_t>(cell_posts);
  const auto cols = static_cast<std::size_t>(shape.cols);
  const std::size_t grid_cols = (cols + n - 1) / n;
  const auto owned = static_cast<std::size_t>(owned_rows(shape, band.y));
  std::vector<FillGrid::Cell> cells((owned + n - 1) / n * grid_cols);
  for (std::size_t r = 0; r < owned; ++r) {
    const auto row = band_row(band, shape.cols, static_cast<int>(r));
    FillGrid::Cell* out = &cells[r / n * grid_cols];
    for (std::size_t c = 0; c < cols; c += n, ++out)
      for (const std::int32_t count : row.subspan(c, std::min(n, cols - c)))
        if (count != kAbsent) {
          out->sum += count;
          ++out->count;
        }
  }
  return cells;
}

}  // namespace

std::vector<std::byte> BandSummary::to_bytes() const {
  std::vector<std::byte> bytes;
  ByteWriter writer(bytes);
  summary_fields(writer, *this);
  for (const FillGrid::Cell& cell : fill_cells) {
    writer(cell.sum);
    writer(cell.count);
  }
  return bytes;
}

BandSummary BandSummary::from_bytes(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  BandSummary summary;
  summary_fields(reader, summary);
  while (reader.left() > 0) {
    FillGrid::Cell cell;
    reader(cell.sum);
    reader(cell.count);
    summary.fill_cells.push_back(cell);
  }
  return summary;
}

int owned_rows(const PyramidShape& shape, int y) {
  const int left = shape.rows - y * kTileCells;
  return y + 1 == shape.tiles_y(0) ? left : kTileCells;
}

void store_band(const PyramidShape& shape, int fill_cell_posts, const SourceBand& band,
                UnitWriter& unit) {
  BandSummary summary;
  summary.stats = band.stats;
  summary.has_holes = has_holes(band, shape.cols) ? 1 : 0;
  summary.fill_cells = sum_cells(band, shape, fill_cell_posts);
  thread_local HeightTile tile;
  thread_local std::vector<std::byte> raw;
  for (int x = 0; x < shape.tiles_x(0); ++x) {
    const Extent extent = extent_of(shape, x, band.y);
    cut_tile(band, shape.cols, x, extent, tile);
    const bool whole = extent.cols == kTilePosts && extent.rows == kTilePosts;
    tile.valid.clear();
    if (!whole || summary.has_holes != 0) mark_valid(extent, tile);
    if (whole && std::ranges::find(tile.valid, 0) == tile.valid.end()) tile.valid.clear();
    const std::uint64_t drawable = count_drawable(tile);
    if (drawable == 0) continue;
    summary.drawable_cells += drawable;
    repeat_edges(extent.cols, extent.rows, tile.counts);
    if (summary.has_holes != 0) patch_holes(tile.counts);
    encode_tile(tile.counts, tile.valid, raw);
    unit.add(TileId{0, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(band.y)}.key(),
             raw);
  }
  unit.set_aux(summary.to_bytes());
}

void fill_band(const PyramidShape& shape, const FillGrid& grid, const UnitReader& from,
               UnitWriter& to) {
  HeightTile tile;
  std::vector<std::byte> raw;
  for (const BlockEntry& entry : from.entries()) {
    from.read(entry.key, raw);
    decode_tile(raw, tile);
    if (!tile.valid.empty()) {
      const TileId id = TileId::from_key(entry.key);
      const Extent extent = extent_of(shape, static_cast<int>(id.x), static_cast<int>(id.y));
      const Post corner{static_cast<int>(id.x) * kTileCells, static_cast<int>(id.y) * kTileCells};
      for (int r = 0; r < extent.rows; ++r)
        for (int c = 0; c < extent.cols; ++c)
          if (!tile.is_valid(c, r))
            tile.counts[static_cast<std::size_t>(r) * kTilePosts + static_cast<std::size_t>(c)] =
                grid.at({corner.col + c, corner.row + r});
      repeat_edges(extent.cols, extent.rows, tile.counts);
      encode_tile(tile.counts, tile.valid, raw);
    }
    to.add(entry.key, raw);
  }
  to.set_aux({from.aux().begin(), from.aux().end()});
}

}  // namespace arete::store
