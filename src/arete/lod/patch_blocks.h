#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/lod/engine.h"
#include "arete/lod/patch_table.h"
#include "arete/store/terrain.h"

namespace arete::lod {

/// Where each factor of a batch stands (METHODS 7.3, DESIGN 3): the nine of [Wagner2003] in product
/// form, with the side factor told apart by whether the side stands at the patch's own level (a) or
/// one coarser (b); c = tI b.
struct PatchSlot {
  static constexpr std::uint8_t kInterior = 0;
  static std::uint8_t own(Side q) { return static_cast<std::uint8_t>(1 + q); }
  static std::uint8_t coarser(Side q) { return static_cast<std::uint8_t>(5 + q); }
  static std::uint8_t product(Side q) { return static_cast<std::uint8_t>(9 + q); }
};

/// Fills the vertices of a patch standing at a level, from the counts of its (cells + 1)^2 posts of
/// that level: positions, and what each factor moves them by.
void make_patch_vertices(const RtinSquare& square, std::span<const std::int32_t> counts,
                         Post origin, int level, const store::Manifest& lattice,
                         std::span<Vertex> out);

/// Immutable vertex and index blocks of all patches, made on demand from the store's height pyramid
/// and kept until the budget asks for their room. A key names (level, patch), so its content never
/// changes. Slots are reused: no allocation once the path's blocks fit the budget.
class PatchBlocks {
 public:
  PatchBlocks(const store::Terrain& terrain, const PatchTable& table, Topology topology,
              std::size_t budget_bytes);

  void begin_frame() { ++frame_; }
  /// Vertex block of the patch at the level, made if needed; kOwnBlock when its heights are
  /// missing. Level w never fails: the table knows the corners.
  BlockKey vertices(int patch, int level, OnMissing on_missing, RefineStats& stats);
  /// The stored height tile that block (patch, level) is made from. Requires: level < w.
  TileId tile_of(int patch, int level) const;
  BlockKey indices(int patch, int level, unsigned side_mask) const;
  std::uint32_t index_count(BlockKey indices_key) const;
  std::uint64_t triangles(int level, unsigned side_mask) const;

  std::span<const Vertex> vertex_span(BlockKey key) const;
  std::span<const std::uint32_t> index_span(BlockKey key) const;
  std::uint64_t resident_bytes() const { return bytes_; }

 private:
  struct Slot {
    int patch = -1;
    std::uint64_t used = 0;  ///< frame
    std::vector<Vertex> vertices;
  };
  struct Level {
    std::vector<int> slot_of_patch;
    std::vector<Slot> slots;
    std::vector<std::size_t> free;  ///< slots without a patch
    std::size_t hand = 0;           ///< where the search for a slot to reuse goes on
  };
  std::size_t take_slot(Level& level, std::size_t posts);
  void release_unused(std::size_t wanted_bytes);
  bool idle(const Slot& slot) const { return slot.used + 1 < frame_; }
  bool fill(int patch, int level, OnMissing on_missing, std::span<Vertex> out);
  TileId tile_at(int patch, int stored) const;
  int level_cells(int level) const { return table_.cells() >> level; }

  const store::Terrain& terrain_;
  const PatchTable& table_;
  Topology topology_;
  std::size_t budget_, bytes_ = 0;
  std::uint64_t frame_ = 0;
  std::vector<Level> levels_;
  std::vector<std::int32_t> counts_;  ///< scratch
  /// [level][side mask], and the two parities of level w at its masks 0 and 1.
  std::vector<std::array<std::vector<std::uint32_t>, 16>> index_lists_;
};

}  // namespace arete::lod
