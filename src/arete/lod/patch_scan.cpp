#include "arete/lod/patch_scan.h"

#include <algorithm>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::lod {
namespace {

using store::kTileCells;
using store::kTilePosts;

// A tile with its posts of drawable cells.
class CountedTile {
 public:
  explicit CountedTile(std::shared_ptr<const store::HeightTile> tile) : tile_(std::move(tile)) {
    if (!tile_ || tile_->valid.empty()) return;
    counted_.assign(tile_->counts.size(), 0);
    for (int r = 0; r < kTileCells; ++r) {
      for (int c = 0; c < kTileCells; ++c) {
        if (!drawable_cell(c, r)) continue;
        for (const int i : {at(c, r), at(c + 1, r), at(c, r + 1), at(c + 1, r + 1)})
          counted_[static_cast<std::size_t>(i)] = 1;
      }
    }
  }

  // Gives the patch whose first cell is (col, row).
  void record(int w, Post first, bool odd, const PatchRecorder& recorder) const {
    if (!tile_) return recorder(nullptr);
    const int n = 1 << w;
    const auto start = static_cast<std::size_t>(at(first.col, first.row));
    PatchHeights patch{tile_->counts.data() + start, kTilePosts, w, odd, nullptr};
    if (!counted_.empty()) {
      bool any = false;
      bool all = true;
      for (int r = first.row; r <= first.row + n; ++r) {
        for (int c = first.col; c <= first.col + n; ++c) {
          const bool inside = c < first.col + n && r < first.row + n;
          any = any || (inside && drawable_cell(c, r));
          all = all && counted_[static_cast<std::size_t>(at(c, r))] != 0;
        }
      }
      if (!any) return recorder(nullptr);
      if (!all) patch.counted = counted_.data() + start;
    }
    recorder(&patch);
  }

 private:
  static int at(int col, int row) { return row * kTilePosts + col; }
  bool drawable_cell(int c, int r) const {
    return tile_->is_valid(c, r) && tile_->is_valid(c + 1, r) && tile_->is_valid(c, r + 1) &&
           tile_->is_valid(c + 1, r + 1);
  }

  std::shared_ptr<const store::HeightTile> tile_;
  std::vector<std::uint8_t> counted_;  // kTilePosts^2; empty when every cell is drawable
};

// Blocks run along rows of tiles, records along rows of patches: so a row's tiles are held.
void record_row(const store::Terrain& terrain, int w, int unit, const PatchRecorder& recorder) {
  std::vector<CountedTile> tiles;
  for (int x = 0; x < terrain.tiles_x(0); ++x) {
    tiles.emplace_back(terrain.heights(
        {0, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(unit)}, store::Fetch::Wait));
  }
  const int n = 1 << w;
  const int per_tile = kTileCells / n;
  const int rows = patches_along(terrain.manifest().rows, w);
  for (int j = 0; j < per_tile && unit * per_tile + j < rows; ++j) {
    for (int x = 0; x < patches_along(terrain.manifest().cols, w); ++x) {
      const bool odd = ((x + unit * per_tile + j) & 1) != 0;
      tiles[static_cast<std::size_t>(x / per_tile)].record(w, {x % per_tile * n, j * n}, odd,
                                                           recorder);
    }
  }
}

}  // namespace

int patches_along(int posts, int log2_cells) {
  const int cells = 1 << log2_cells;
  return (std::max(posts - 1, 0) + cells - 1) / cells;
}

void write_patch_records(
    const store::Terrain& terrain, store::Writers& writers, const store::SegmentPlan& named,
    int log2_cells,
    const std::function<PatchRecorder(std::vector<std::byte>& bytes)>& make_recorder) {
  const int per_tile = kTileCells >> log2_cells;
  const int cols = patches_along(terrain.manifest().cols, log2_cells);
  const int rows = patches_along(terrain.manifest().rows, log2_cells);
  store::SegmentPlan plan = named;
  plan.units = cols == 0 || rows == 0 ? 0 : (rows + per_tile - 1) / per_tile;
  plan.make = [&](int unit, store::BlockSink& sink) {
    std::vector<std::byte> bytes;
    record_row(terrain, log2_cells, unit, make_recorder(bytes));
    sink.add(static_cast<std::uint64_t>(unit), bytes);
  };
  writers.write(plan);
}

void read_patch_records(const store::Terrain& terrain, const std::string& segment, int log2_cells,
                        std::size_t record_size,
                        const std::function<void(int patch, const std::byte* record)>& read) {
  const int cols = patches_along(terrain.manifest().cols, log2_cells);
  const int rows = patches_along(terrain.manifest().rows, log2_cells);
  const int per_unit = kTileCells >> log2_cells;
  for (const std::uint64_t key : terrain.keys(segment)) {
    const auto block = terrain.block(segment, key, store::Fetch::Wait);
    const int first_row = static_cast<int>(key) * per_unit;
    const int records = std::min(per_unit, rows - first_row) * cols;
    if (!block || records <= 0 ||
        block->size() != static_cast<std::size_t>(records) * record_size) {
      throw Error(ErrorCode::Corrupt,
                  fmt::format("{}: block {} of \"{}\" is damaged: build it again with --force",
                              terrain.name(), key, segment));
    }
    for (int k = 0; k < records; ++k)
      read(first_row * cols + k, block->data() + static_cast<std::size_t>(k) * record_size);
  }
}

}  // namespace arete::lod
