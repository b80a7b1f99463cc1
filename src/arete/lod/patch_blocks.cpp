#include "arete/lod/patch_blocks.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace arete::lod {
namespace {

// Keys: bit 63 tells indices from vertices, so no key is kOwnBlock.
// Vertices: level + 1, the mesh's variant, patch. Indices: level, the mesh's variant.
constexpr BlockKey kIndexBit = BlockKey{1} << 63U;

BlockKey vertex_key(int level, unsigned variant, int patch) {
  return BlockKey{static_cast<unsigned>(level) + 1} << 48U | BlockKey{variant} << 32U |
         static_cast<std::uint32_t>(patch);
}

// Index blocks that take no more than this are all made at once.
constexpr std::uint64_t kFewBytes = std::uint64_t{16} << 20U;

}  // namespace

PatchBlocks::PatchBlocks(const store::Terrain& terrain, const PatchTable& table,
                         std::unique_ptr<const PatchMesh> mesh)
    : terrain_(terrain), table_(table), mesh_(std::move(mesh)) {
  levels_.resize(table.knots());
  index_lists_.resize(table.knots());
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    levels_[l].slot_of_patch.assign(static_cast<std::size_t>(table.size()), -1);
    index_lists_[l].resize(mesh_->index_variants(level_cells(static_cast<int>(l))));
  }
  counts_.resize(static_cast<std::size_t>((table.cells() + 1) * (table.cells() + 1)));
  if (index_bytes() > kFewBytes) return;
  for (int l = 0; l <= table.log2_cells(); ++l) {
    const auto variants = static_cast<unsigned>(index_lists_[static_cast<std::size_t>(l)].size());
    for (unsigned variant = 0; variant < variants; ++variant) keep_indices(l, variant);
  }
}

void PatchBlocks::keep_indices(int level, unsigned variant) {
  auto& list = index_lists_[static_cast<std::size_t>(level)][variant];
  if (list.empty()) list = mesh_->make_indices(level_cells(level), variant);
}

void PatchBlocks::set_cap(std::uint64_t vertex_bytes) {
  if (vertex_bytes == cap_) return;
  cap_ = vertex_bytes;
  begin_use();
  release_idle(0);
}

void PatchBlocks::begin_use() {
  ++use_;
  for (Level& level : levels_) level.tried = 0;
  release_level_ = release_slot_ = 0;
}

void PatchBlocks::use(int patch, int level) {
  Level& store = levels_[static_cast<std::size_t>(level)];
  const int index = store.slot_of_patch[static_cast<std::size_t>(patch)];
  if (index >= 0) store.slots[static_cast<std::size_t>(index)].used = use_;
}

BlockKey PatchBlocks::vertices(int patch, const PatchStanding& standing, OnMissing on_missing,
                               RefineStats& stats) {
  const int level = standing.own.level;
  const unsigned variant = mesh_->vertex_variant(standing);
  Level& store = levels_[static_cast<std::size_t>(level)];
  int& index = store.slot_of_patch[static_cast<std::size_t>(patch)];
  const bool there = index >= 0;
  const std::size_t taken =
      there ? static_cast<std::size_t>(index) : take_slot(store, vertex_bytes(level));
  Slot& slot = store.slots[taken];
  if (!there || slot.variant != variant) {
    if (!fill(patch, standing, on_missing, slot.vertices)) {
      if (!there) store.free.push_back(taken);
      return kOwnBlock;
    }
    slot.patch = patch;
    slot.variant = variant;
    index = static_cast<int>(taken);
    ++stats.built_blocks;
    stats.bytes_built += vertex_bytes(level);
  }
  slot.used = use_;
  return vertex_key(level, variant, patch);
}

// A free slot, else a new one while there is room, else one of the level that is not in use, else
// the room of such ones of other levels. Without a cap, what is in use may outgrow the rest.
std::size_t PatchBlocks::take_slot(Level& level, std::uint64_t bytes) {
  std::size_t index = level.slots.size();
  if (!level.free.empty()) {
    index = level.free.back();
    level.free.pop_back();
    return index;
  }
  if (bytes_ + bytes > most_bytes()) {
    if (take_idle(level, index)) return index;
    release_idle(bytes);
  }
  assert(bytes_ + bytes <= cap_);
  if (level.bare.empty()) {
    level.slots.emplace_back();
  } else {
    index = level.bare.back();
    level.bare.pop_back();
  }
  level.slots[index].vertices.resize(bytes / sizeof(Vertex));
  bytes_ += bytes;
  return index;
}

bool PatchBlocks::take_idle(Level& level, std::size_t& index) {
  while (level.tried < level.slots.size()) {
    ++level.tried;
    level.hand = (level.hand + 1) % level.slots.size();
    Slot& slot = level.slots[level.hand];
    if (slot.patch < 0 || slot.used == use_) continue;
    level.slot_of_patch[static_cast<std::size_t>(slot.patch)] = -1;
    slot.patch = -1;
    index = level.hand;
    return true;
  }
  return false;
}

// Within one use nothing falls idle, so the search goes on where it stopped; slots that a failed
// fill set free behind it are taken first by the next block of their level.
void PatchBlocks::release_idle(std::uint64_t wanted_bytes) {
  for (; release_level_ < levels_.size(); ++release_level_, release_slot_ = 0) {
    Level& level = levels_[release_level_];
    for (; release_slot_ < level.slots.size(); ++release_slot_) {
      if (bytes_ + wanted_bytes <= most_bytes()) return;
      release(level, release_slot_);
    }
  }
}

void PatchBlocks::release(Level& level, std::size_t index) {
  Slot& slot = level.slots[index];
  if (slot.vertices.empty() || (slot.patch >= 0 && slot.used == use_)) return;
  if (slot.patch >= 0) {
    level.slot_of_patch[static_cast<std::size_t>(slot.patch)] = -1;
    slot.patch = -1;
  } else {
    std::erase(level.free, index);
  }
  level.bare.push_back(index);
  bytes_ -= slot.vertices.size() * sizeof(Vertex);
  slot.vertices = {};
}

// A small terrain's pyramid ends before level w - 1, and coarse tiles of sparse land may hold no
// valid post: then every so many posts of a finer tile. Level 0 has every drawable patch.
TileId PatchBlocks::tile_of(int patch, int level) const {
  const std::span<const std::uint64_t> stored = terrain_.keys("heights");
  int from = std::min(level, terrain_.levels() - 1);
  while (from > 0 && !std::ranges::binary_search(stored, tile_at(patch, from).key())) --from;
  return tile_at(patch, from);
}

TileId PatchBlocks::tile_at(int patch, int stored) const {
  const int cells = table_.cells() >> stored;
  return {static_cast<std::uint32_t>(stored),
          static_cast<std::uint32_t>(table_.x(patch) * cells / store::kTileCells),
          static_cast<std::uint32_t>(table_.y(patch) * cells / store::kTileCells)};
}

bool PatchBlocks::fill(int patch, const PatchStanding& standing, OnMissing on_missing,
                       std::span<Vertex> out) {
  const int w = table_.log2_cells();
  const int level = standing.own.level;
  const int n = level_cells(level);
  const int x = table_.x(patch);
  const int y = table_.y(patch);
  const std::span<std::int32_t> counts = std::span(counts_).first(out.size());
  if (level == w) {
    std::ranges::copy(table_.corners(patch), counts.begin());
  } else {
    const TileId id = tile_of(patch, level);
    const int stride = 1 << (level - static_cast<int>(id.level));
    const auto tile = terrain_.heights(
        id, on_missing == OnMissing::Wait ? store::Fetch::Wait : store::Fetch::Resident);
    if (!tile) return false;
    const int col = x * n * stride % store::kTileCells;
    const int row = y * n * stride % store::kTileCells;
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) {
        counts[local_vertex({n}, i, j)] = tile->counts[static_cast<std::size_t>(
            (row + j * stride) * store::kTilePosts + col + i * stride)];
      }
    }
  }
  mesh_->make_vertices({counts, n, level, {x << w, y << w}, standing.odd},
                       mesh_->vertex_variant(standing), terrain_.manifest(), out);
  return true;
}

BlockKey PatchBlocks::indices(const PatchStanding& standing) {
  const int level = standing.own.level;
  const unsigned variant = mesh_->index_variant(standing, level_cells(level));
  keep_indices(level, variant);
  return kIndexBit | BlockKey{static_cast<unsigned>(level)} << 32U | variant;
}

std::uint32_t PatchBlocks::index_count(BlockKey key) const {
  return static_cast<std::uint32_t>(index_span(key).size());
}

std::uint64_t PatchBlocks::triangles(const PatchStanding& standing) const {
  const int cells = level_cells(standing.own.level);
  return mesh_->triangles(cells, mesh_->index_variant(standing, cells));
}

std::uint64_t PatchBlocks::vertex_bytes(int level) const {
  const auto side = static_cast<std::uint64_t>(level_cells(level) + 1);
  return side * side * sizeof(Vertex);
}

// A strip is never longer than the list.
std::uint64_t PatchBlocks::index_bytes() const {
  std::uint64_t count = 0;
  for (std::size_t l = 0; l < index_lists_.size(); ++l) {
    const int cells = level_cells(static_cast<int>(l));
    const auto variants = static_cast<unsigned>(index_lists_[l].size());
    for (unsigned variant = 0; variant < variants; ++variant)
      count += 3 * mesh_->triangles(cells, variant);
  }
  return count * sizeof(std::uint32_t);
}

std::uint64_t PatchBlocks::table_bytes() const {
  return levels_.size() * static_cast<std::uint64_t>(table_.size()) * sizeof(int) + index_bytes();
}

std::span<const Vertex> PatchBlocks::vertex_span(BlockKey key) const {
  const auto level = static_cast<std::size_t>((key >> 48U) - 1);
  const auto patch = static_cast<std::size_t>(key & 0xFFFFFFFFU);
  const int slot = levels_[level].slot_of_patch[patch];
  assert(slot >= 0);
  return levels_[level].slots[static_cast<std::size_t>(slot)].vertices;
}

std::span<const std::uint32_t> PatchBlocks::index_span(BlockKey key) const {
  return index_lists_[static_cast<std::size_t>(key >> 32U & 0xFFU)][key & 0xFFFFFFFFU];
}

}  // namespace arete::lod
