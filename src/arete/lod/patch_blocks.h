#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/lod/engine.h"
#include "arete/lod/patch_mesh.h"
#include "arete/lod/patch_table.h"
#include "arete/store/terrain.h"

namespace arete::lod {

/// Immutable vertex and index blocks of all patches, made on demand from the store's height pyramid
/// and kept until others need their room. A key names what it holds, so its content never changes:
/// (level, patch, the mesh's variant), of which one variant is kept. Slots are reused: no
/// allocation once the path's blocks fit.
class PatchBlocks {
 public:
  static constexpr std::uint64_t kKeepBytes = std::uint64_t{256} << 20U;  ///< without a cap

  PatchBlocks(const store::Terrain& terrain, const PatchTable& table,
              std::unique_ptr<const PatchMesh> mesh);

  const PatchMesh& mesh() const { return *mesh_; }

  /// Most bytes of vertices to hold, Budget::kUnlimited = what is in use and up to kKeepBytes.
  /// A change ends what is in use. Requires: room for what will be in use at once.
  void set_cap(std::uint64_t vertex_bytes);
  /// Nothing is in use any more: any block may make room for another.
  void begin_use();
  /// Takes the block into use if it is there: it stays until the next begin_use.
  void use(int patch, int level);
  /// Vertex block of the patch as it stands, made if needed, in use; kOwnBlock when its heights are
  /// missing. Level w never fails: the table knows the corners.
  BlockKey vertices(int patch, const PatchStanding& standing, OnMissing on_missing,
                    RefineStats& stats);
  /// The stored height tile that block (patch, level) is made from. Requires: level < w.
  TileId tile_of(int patch, int level) const;
  /// Index block of a patch that stands so, made if needed.
  BlockKey indices(const PatchStanding& standing);
  std::uint32_t index_count(BlockKey indices_key) const;
  std::uint64_t triangles(const PatchStanding& standing) const;
  std::uint64_t vertex_bytes(int level) const;  ///< of a block
  std::uint64_t index_bytes() const;            ///< most that all index blocks may take
  std::uint64_t table_bytes() const;

  std::span<const Vertex> vertex_span(BlockKey key) const;
  std::span<const std::uint32_t> index_span(BlockKey key) const;
  std::uint64_t resident_bytes() const { return bytes_; }

 private:
  struct Slot {
    int patch = -1;
    unsigned variant = 0;
    std::uint64_t used = 0;  ///< use_ when it was last in use
    std::vector<Vertex> vertices;
  };
  struct Level {
    std::vector<int> slot_of_patch;
    std::vector<Slot> slots;
    std::vector<std::size_t> free, bare;  ///< slots without a patch: with vertices, without
    std::size_t hand = 0;                 ///< where the search for a slot to reuse goes on
    std::size_t tried = 0;                ///< slots that it looked at since begin_use
  };
  std::size_t take_slot(Level& level, std::uint64_t bytes);
  bool take_idle(Level& level, std::size_t& index);
  void release_idle(std::uint64_t wanted_bytes);
  void release(Level& level, std::size_t index);
  std::uint64_t most_bytes() const { return cap_ == Budget::kUnlimited ? kKeepBytes : cap_; }
  void keep_indices(int level, unsigned variant);
  bool fill(int patch, const PatchStanding& standing, OnMissing on_missing, std::span<Vertex> out);
  TileId tile_at(int patch, int stored) const;
  int level_cells(int level) const { return table_.cells() >> level; }

  const store::Terrain& terrain_;
  const PatchTable& table_;
  std::unique_ptr<const PatchMesh> mesh_;
  std::uint64_t cap_ = Budget::kUnlimited;
  std::uint64_t bytes_ = 0, use_ = 0;
  std::size_t release_level_ = 0, release_slot_ = 0;  ///< where release_idle goes on
  std::vector<Level> levels_;
  std::vector<std::int32_t> counts_;                                  ///< scratch
  std::vector<std::vector<std::vector<std::uint32_t>>> index_lists_;  ///< [level][variant]
};

}  // namespace arete::lod
