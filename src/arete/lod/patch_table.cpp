#include "arete/lod/patch_table.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/lod/error_tables.h"

namespace arete::lod {
namespace {

using store::kTileCells;
using store::kTilePosts;

int patches(int posts, int cells) {
  return (std::max(posts - 1, 0) + cells - 1) / cells;
}

// One record of the segment: 7 int32, then w uniform and 4 w side errors as float (levels 1..w),
// all little-endian. flag 0 = not drawable, and nothing else of the record counts.
struct RecordHead {
  std::int32_t drawable = 0;
  std::int32_t z_min = 0, z_max = 0;  // lattice counts over all posts of the patch
  std::array<std::int32_t, 4> corners{};
};
std::size_t record_size(int w) {
  return sizeof(RecordHead) + static_cast<std::size_t>(5 * w) * sizeof(float);
}

// Rounded up, so that the stored bound still is one.
float rounded_up(double metres) {
  if (metres <= 0) return 0;
  return std::nextafter(static_cast<float>(metres), std::numeric_limits<float>::infinity());
}

// Cells of the tile whose four posts are valid, and the posts of such cells.
struct Drawable {
  std::vector<std::uint8_t> counted;  // kTilePosts^2; empty when every cell is drawable
  explicit Drawable(const store::HeightTile& tile) {
    if (tile.valid.empty()) return;
    counted.assign(tile.counts.size(), 0);
    for (int r = 0; r < kTileCells; ++r) {
      for (int c = 0; c < kTileCells; ++c) {
        if (!tile.is_valid(c, r) || !tile.is_valid(c + 1, r) || !tile.is_valid(c, r + 1) ||
            !tile.is_valid(c + 1, r + 1)) {
          continue;
        }
        for (const int i : {r * kTilePosts + c, r * kTilePosts + c + 1, (r + 1) * kTilePosts + c,
                            (r + 1) * kTilePosts + c + 1}) {
          counted[static_cast<std::size_t>(i)] = 1;
        }
      }
    }
  }
};

class RecordWriter {
 public:
  RecordWriter(const store::Manifest& manifest, int w) : manifest_(manifest), w_(w) {}

  // `tile_x/y`: the patch's first cell within the store's tile.
  void append(const store::HeightTile& tile, const Drawable& drawable, Post origin, bool odd) {
    const int n = 1 << w_;
    const std::size_t first = static_cast<std::size_t>(origin.row * kTilePosts + origin.col);
    const PatchHeights heights{
        tile.counts.data() + first, kTilePosts, w_, odd,
        drawable.counted.empty() ? nullptr : drawable.counted.data() + first};
    RecordHead head;
    head.z_min = std::numeric_limits<std::int32_t>::max();
    head.z_max = std::numeric_limits<std::int32_t>::min();
    bool any = heights.counted == nullptr;
    bool all = true;
    for (int r = 0; r <= n; ++r) {
      for (int c = 0; c <= n; ++c) {
        const std::ptrdiff_t i = r * kTilePosts + c;
        head.z_min = std::min(head.z_min, heights.counts[i]);
        head.z_max = std::max(head.z_max, heights.counts[i]);
        if (heights.counted == nullptr) continue;
        any = any || drawable_cell(heights, tile, origin, c, r);
        all = all && heights.counted[i] != 0;
      }
    }
    if (!any) return append_empty();
    head.drawable = 1;
    head.corners = {heights.counts[0], heights.counts[n], heights.counts[n * kTilePosts],
                    heights.counts[n * kTilePosts + n]};
    PatchHeights measured = heights;
    if (all) measured.counted = nullptr;
    write(head, patch_errors(measured));
  }

  void append_empty() { write({}, {}); }
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  bool drawable_cell(const PatchHeights& h, const store::HeightTile& tile, Post origin, int c,
                     int r) const {
    const int n = 1 << h.log2_cells;
    if (c == n || r == n) return false;
    const int col = origin.col + c;
    const int row = origin.row + r;
    return tile.is_valid(col, row) && tile.is_valid(col + 1, row) && tile.is_valid(col, row + 1) &&
           tile.is_valid(col + 1, row + 1);
  }

  void write(const RecordHead& head, const PatchErrors& errors) {
    const auto metres = [&](const std::vector<double>& counts, std::size_t level) {
      return counts.empty() ? 0.0F : rounded_up(counts[level] * manifest_.quantum_m);
    };
    std::vector<float> values;
    for (std::size_t l = 1; l <= static_cast<std::size_t>(w_); ++l)
      values.push_back(metres(errors.uniform, l));
    for (const auto& side : errors.side) {
      for (std::size_t l = 1; l <= static_cast<std::size_t>(w_); ++l)
        values.push_back(metres(side, l));
    }
    const std::size_t old = bytes_.size();
    bytes_.resize(old + record_size(w_));
    std::memcpy(bytes_.data() + old, &head, sizeof head);
    std::memcpy(bytes_.data() + old + sizeof head, values.data(), values.size() * sizeof(float));
  }

  const store::Manifest& manifest_;
  int w_;
  std::vector<std::byte> bytes_;
};

}  // namespace

std::string tables_segment(int log2_cells) {
  return fmt::format("tables-{}", (1 << log2_cells) + 1);
}

int default_log2_cells(const store::Manifest& manifest) {
  int w = 4;
  while (w < 7 &&
         std::int64_t{patches(manifest.cols, 1 << w)} * patches(manifest.rows, 1 << w) > 16384)
    ++w;
  return w;
}

int parse_patch(std::string_view text, const store::Manifest& manifest) {
  if (text == "auto") return default_log2_cells(manifest);
  for (int w = 3; w <= 7; ++w) {
    if (text == std::to_string((1 << w) + 1)) return w;
  }
  throw Error(
      ErrorCode::Usage,
      fmt::format("patch={}: not a patch size: use auto, 9, 17, 33, 65 or 129 posts", text));
}

void write_patch_table(const store::Terrain& terrain, store::Writers& writers, int w) {
  const store::Manifest& m = terrain.manifest();
  const int n = 1 << w;
  const int per_tile = kTileCells / n;
  const int cols = patches(m.cols, n);
  const int rows = patches(m.rows, n);
  const auto make = [&, w](int unit, store::BlockSink& sink) {
    RecordWriter writer(m, w);
    // Tiles of this row of tiles, one after the other, would give records tile by tile; readers
    // want rows of patches, so the row's tiles are held.
    std::vector<std::shared_ptr<const store::HeightTile>> tiles;
    std::vector<Drawable> drawable;
    for (int x = 0; x < terrain.tiles_x(0); ++x) {
      tiles.push_back(
          terrain.heights({0, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(unit)},
                          store::Fetch::Wait));
      drawable.emplace_back(tiles.back() ? Drawable(*tiles.back()) : Drawable(store::HeightTile{}));
    }
    for (int j = 0; j < per_tile && unit * per_tile + j < rows; ++j) {
      for (int x = 0; x < cols; ++x) {
        const auto t = static_cast<std::size_t>(x / per_tile);
        const int y = unit * per_tile + j;
        if (!tiles[t]) {
          writer.append_empty();
        } else {
          writer.append(*tiles[t], drawable[t], {x % per_tile * n, j * n}, ((x + y) & 1) != 0);
        }
      }
    }
    sink.add(static_cast<std::uint64_t>(unit), writer.bytes());
  };
  writers.write({tables_segment(w), fmt::format("patch-tables 1 cells={}", n),
                 cols == 0 || rows == 0 ? 0 : (rows + per_tile - 1) / per_tile, make});
}

PatchTable::PatchTable(const store::Terrain& terrain, int log2_cells)
    : w_(log2_cells),
      cols_(patches(terrain.manifest().cols, 1 << log2_cells)),
      rows_(patches(terrain.manifest().rows, 1 << log2_cells)),
      quantum_(terrain.manifest().quantum_m),
      offset_(terrain.manifest().offset_m),
      world_from_post_(terrain.manifest().georef.world_from_post) {
  const std::string segment = tables_segment(w_);
  if (!terrain.has_segment(segment)) {
    throw Error(
        ErrorCode::NotFound,
        fmt::format("{}.seg: the store has no tables for patches of {} posts: rebuild it with "
                    "--patch {}",
                    segment, cells() + 1, cells() + 1));
  }
  if (cols_ == 0 || rows_ == 0) cols_ = rows_ = 0;
  const auto n = static_cast<std::size_t>(size());
  drawable_.resize(n);
  box_min_.resize(n);
  box_max_.resize(n);
  corners_.resize(n);
  uniform_.resize(n * knots());
  side_.resize(n * kSides * knots());
  const int per_unit = kTileCells / cells();
  for (const std::uint64_t key : terrain.keys(segment)) {
    const auto block = terrain.block(segment, key, store::Fetch::Wait);
    const int first_row = static_cast<int>(key) * per_unit;
    const int unit_rows = std::min(per_unit, rows_ - first_row);
    if (!block || unit_rows <= 0 ||
        block->size() != static_cast<std::size_t>(unit_rows * cols_) * record_size(w_)) {
      throw Error(
          ErrorCode::Corrupt,
          fmt::format("{}.seg: block {} is damaged: rebuild the store with --force", segment, key));
    }
    read_unit(*block, first_row);
  }
}

void PatchTable::read_unit(std::span<const std::byte> bytes, int first_row) {
  const std::size_t size = record_size(w_);
  for (std::size_t k = 0; k * size < bytes.size(); ++k) {
    const std::byte* record = bytes.data() + k * size;
    const std::size_t p = at(first_row * cols_) + k;
    RecordHead head;
    std::memcpy(&head, record, sizeof head);
    drawable_[p] = head.drawable != 0 ? 1 : 0;
    corners_[p] = head.corners;
    const std::byte* floats = record + sizeof head;
    const std::size_t levels = static_cast<std::size_t>(w_) * sizeof(float);
    std::memcpy(&uniform_[p * knots() + 1], floats, levels);
    for (std::size_t q = 0; q < kSides; ++q) {
      std::memcpy(&side_[(p * kSides + q) * knots() + 1], floats + (q + 1) * levels, levels);
    }
    const double col = x(static_cast<int>(p)) * cells();
    const double row = y(static_cast<int>(p)) * cells();
    const std::array<glm::dvec2, 4> plan{world_from_post_.apply(col, row),
                                         world_from_post_.apply(col + cells(), row),
                                         world_from_post_.apply(col, row + cells()),
                                         world_from_post_.apply(col + cells(), row + cells())};
    glm::dvec2 lo = plan[0];
    glm::dvec2 hi = plan[0];
    for (const glm::dvec2& corner : plan) {
      lo = glm::min(lo, corner);
      hi = glm::max(hi, corner);
    }
    box_min_[p] = {lo, offset_ + quantum_ * head.z_min};
    box_max_[p] = {hi, offset_ + quantum_ * head.z_max};
  }
}

int PatchTable::neighbour(int patch, Side q) const {
  const auto [dx, dy] = step(q);
  const int nx = x(patch) + dx;
  const int ny = y(patch) + dy;
  if (nx < 0 || ny < 0 || nx >= cols_ || ny >= rows_) return -1;
  return drawable(index(nx, ny)) ? index(nx, ny) : -1;
}

std::uint64_t PatchTable::bytes() const {
  return drawable_.size() * (1 + 2 * sizeof(glm::dvec3) + sizeof(corners_[0])) +
         (uniform_.size() + side_.size()) * sizeof(float);
}

}  // namespace arete::lod
