#include "arete/lod/patch_blocks.h"

#include <algorithm>
#include <bit>
#include <cassert>

namespace arete::lod {
namespace {

// Height samples of one patch at one level, in lattice counts.
struct Grid {
  const RtinSquare& square;
  std::span<const std::int32_t> counts;
  double quantum_m;

  std::int64_t at(int i, int j) const { return counts[local_vertex(square, i, j)]; }
  // (h(p1) + h(p2)) / 2 - h(v), metres; exact before the last rounding.
  float delta(std::pair<int, int> p1, std::pair<int, int> p2, std::pair<int, int> v) const {
    const std::int64_t twice =
        at(p1.first, p1.second) + at(p2.first, p2.second) - 2 * at(v.first, v.second);
    return static_cast<float>(static_cast<double>(twice) * quantum_m / 2);
  }
};

// The side that a border position lies on (corners excluded by the caller).
Side side_of(const RtinSquare& s, int i, int j) {
  if (i == 0) return West;
  if (j == 0) return North;
  return i == s.cells ? East : South;
}

bool on_border(const RtinSquare& s, int i, int j) {
  return i == 0 || j == 0 || i == s.cells || j == s.cells;
}

// How a side's post of level l+1 moves while the side goes from l+1 to l+2.
float side_delta_coarser(const Grid& g, Side q, int i, int j) {
  if (q == West || q == East) return g.delta({i, j - 2}, {i, j + 2}, {i, j});
  return g.delta({i - 2, j}, {i + 2, j}, {i, j});
}

// Adds the parent's own motion, halved: the last of Wagner's nine factors (METHODS 7.3).
void add_parent(const Grid& g, std::pair<int, int> parent, Vertex& v, std::size_t& k) {
  const auto [i, j] = parent;
  if (!on_border(g.square, i, j)) return;
  const Side q = side_of(g.square, i, j);
  const int along = q == West || q == East ? j : i;
  if (along % 4 != 2) return;  // of level l+2 or coarser: stands still
  v.dz[k] = side_delta_coarser(g, q, i, j) / 2;
  v.slot[k] = PatchSlot::product(q);
  ++k;
}

void set_border_motion(const Grid& g, int i, int j, Vertex& v) {
  const Side q = side_of(g.square, i, j);
  const int along = q == West || q == East ? j : i;
  if (along % 2 != 0) {
    const auto [p1, p2] = morph_parents(g.square, i, j);
    v.dz[0] = g.delta(p1, p2, {i, j});
    v.slot[0] = PatchSlot::own(q);
  } else if (along % 4 == 2) {
    v.dz[0] = side_delta_coarser(g, q, i, j);
    v.slot[0] = PatchSlot::coarser(q);
  }
}

void set_interior_motion(const Grid& g, int i, int j, Vertex& v) {
  if (i % 2 == 0 && j % 2 == 0) return;
  const auto [p1, p2] = morph_parents(g.square, i, j);
  v.dz[0] = g.delta(p1, p2, {i, j});
  v.slot[0] = PatchSlot::kInterior;
  std::size_t k = 1;
  add_parent(g, p1, v, k);
  add_parent(g, p2, v, k);
}

}  // namespace

void make_patch_vertices(const RtinSquare& square, std::span<const std::int32_t> counts,
                         Post origin, int level, const store::Manifest& lattice,
                         std::span<Vertex> out) {
  const Grid g{square, counts, lattice.quantum_m};
  for (int j = 0; j <= square.cells; ++j) {
    for (int i = 0; i <= square.cells; ++i) {
      Vertex v;
      v.post = {origin.col + (i << level), origin.row + (j << level)};
      v.z = static_cast<float>(lattice.offset_m +
                               lattice.quantum_m * static_cast<double>(g.at(i, j)));
      const bool corner = (i == 0 || i == square.cells) && (j == 0 || j == square.cells);
      if (!corner && on_border(square, i, j)) {
        set_border_motion(g, i, j, v);
      } else if (!corner) {
        set_interior_motion(g, i, j, v);
      }
      out[local_vertex(square, i, j)] = v;
    }
  }
}

namespace {

// Keys: bit 63 tells indices from vertices, so no key is kOwnBlock.
// Vertices: level + 1, patch. Indices: level, side mask.
constexpr BlockKey kIndexBit = BlockKey{1} << 63U;

BlockKey vertex_key(int level, int patch) {
  return BlockKey{static_cast<unsigned>(level) + 1} << 32U | static_cast<std::uint32_t>(patch);
}

}  // namespace

PatchBlocks::PatchBlocks(const store::Terrain& terrain, const PatchTable& table, Topology topology)
    : terrain_(terrain), table_(table), topology_(topology) {
  const int w = table.log2_cells();
  levels_.resize(table.knots());
  index_lists_.resize(table.knots());
  for (int l = 0; l <= w; ++l) {
    levels_[static_cast<std::size_t>(l)].slot_of_patch.assign(
        static_cast<std::size_t>(table.size()), -1);
    for (unsigned mask = 0; mask < 16; ++mask) {
      // One cell has no side to adapt; masks 0 and 1 hold its two diagonals.
      const RtinSquare square{level_cells(l), l == w && mask == 1};
      auto list = rtin_triangles(square, l == w ? 0 : mask);
      if (topology == Topology::Strip) list = as_strip(list);
      index_lists_[static_cast<std::size_t>(l)][mask] = std::move(list);
    }
  }
  counts_.resize(static_cast<std::size_t>((table.cells() + 1) * (table.cells() + 1)));
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

BlockKey PatchBlocks::vertices(int patch, int level, OnMissing on_missing, RefineStats& stats) {
  Level& store = levels_[static_cast<std::size_t>(level)];
  int& index = store.slot_of_patch[static_cast<std::size_t>(patch)];
  if (index < 0) {
    const std::size_t taken = take_slot(store, vertex_bytes(level));
    Slot& slot = store.slots[taken];
    if (!fill(patch, level, on_missing, slot.vertices)) {
      store.free.push_back(taken);
      return kOwnBlock;
    }
    slot.patch = patch;
    index = static_cast<int>(taken);
    ++stats.built_blocks;
    stats.bytes_built += vertex_bytes(level);
  }
  store.slots[static_cast<std::size_t>(index)].used = use_;
  return vertex_key(level, patch);
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

bool PatchBlocks::fill(int patch, int level, OnMissing on_missing, std::span<Vertex> out) {
  const int w = table_.log2_cells();
  const int n = level_cells(level);
  const int x = table_.x(patch);
  const int y = table_.y(patch);
  const RtinSquare square{n, ((x + y) & 1) != 0};
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
        counts[local_vertex(square, i, j)] = tile->counts[static_cast<std::size_t>(
            (row + j * stride) * store::kTilePosts + col + i * stride)];
      }
    }
  }
  make_patch_vertices(square, counts, {x << w, y << w}, level, terrain_.manifest(), out);
  return true;
}

BlockKey PatchBlocks::indices(int patch, int level, unsigned side_mask) const {
  if (level == table_.log2_cells())
    side_mask = static_cast<unsigned>(table_.x(patch) + table_.y(patch)) & 1U;
  return kIndexBit | BlockKey{static_cast<unsigned>(level)} << 8U | side_mask;
}

std::uint32_t PatchBlocks::index_count(BlockKey key) const {
  return static_cast<std::uint32_t>(index_span(key).size());
}

std::uint64_t PatchBlocks::triangles(int level, unsigned side_mask) const {
  const auto n = static_cast<std::uint64_t>(level_cells(level));
  if (n == 1) return 2;
  return 2 * n * n - static_cast<std::uint64_t>(std::popcount(side_mask)) * (n / 2);
}

std::uint64_t PatchBlocks::vertex_bytes(int level) const {
  const auto side = static_cast<std::uint64_t>(level_cells(level) + 1);
  return side * side * sizeof(Vertex);
}

std::uint64_t PatchBlocks::index_bytes() const {
  std::uint64_t count = 0;
  for (const auto& lists : index_lists_) {
    for (const auto& list : lists) count += list.size();
  }
  return count * sizeof(std::uint32_t);
}

std::uint64_t PatchBlocks::table_bytes() const {
  return levels_.size() * static_cast<std::uint64_t>(table_.size()) * sizeof(int) + index_bytes();
}

std::span<const Vertex> PatchBlocks::vertex_span(BlockKey key) const {
  const auto level = static_cast<std::size_t>((key >> 32U & 0xFFU) - 1);
  const auto patch = static_cast<std::size_t>(key & 0xFFFFFFFFU);
  const int slot = levels_[level].slot_of_patch[patch];
  assert(slot >= 0);
  return levels_[level].slots[static_cast<std::size_t>(slot)].vertices;
}

std::span<const std::uint32_t> PatchBlocks::index_span(BlockKey key) const {
  return index_lists_[static_cast<std::size_t>(key >> 8U & 0xFFU)][key & 0xFFU];
}

}  // namespace arete::lod
