#pragma once

#include <vector>

#include "arete/lod/engine.h"
#include "arete/lod/level_field.h"
#include "arete/lod/patch_blocks.h"
#include "arete/lod/patch_table.h"

namespace arete::lod {

/// Turns a level field into a draw list: culls, fetches blocks, sets the factors. What full,
/// geomipmap and other patch methods share; they differ in the field.
class PatchDrawer {
 public:
  /// Throws: as PatchTable. `budget_bytes`: for vertex blocks.
  PatchDrawer(const store::Terrain& terrain, int log2_cells, Topology topology,
              std::size_t budget_bytes);

  const PatchTable& table() const { return table_; }
  LevelField& field() { return field_; }
  const PatchBlocks& blocks() const { return blocks_; }

  /// Draws the field as it stands; where heights are missing, raises it first (and counts).
  void draw(const View& view, const RefineOptions& options, const ScreenError& error,
            DrawList& out);

 private:
  void find_visible(const View& view, const RefineOptions& options, RefineStats& stats);
  void fetch_blocks(const RefineOptions& options, RefineStats& stats);
  bool fetch_missing(const RefineOptions& options, RefineStats& stats);
  void emit(int patch, BlockKey vertices, const ScreenError& error, DrawList& out);

  const store::Terrain& terrain_;
  Affine2 world_from_post_;
  PatchTable table_;
  LevelField field_;
  PatchBlocks blocks_;
  Topology topology_;
  glm::dvec3 box_min_{0}, box_max_{0};
  std::vector<int> visible_;
  std::vector<BlockKey> keys_;      ///< of visible_
  std::vector<float> floor_level_;  ///< finest level whose heights are there
  std::vector<TileId> wanted_;      ///< for prefetch
};

/// An engine whose lists a PatchDrawer fills: methods add the field and their claims.
class PatchEngine : public Engine {
 public:
  PatchEngine(const store::Terrain& terrain, int log2_cells, Topology topology,
              std::size_t budget_bytes)
      : drawer_(terrain, log2_cells, topology, budget_bytes) {}

  std::span<const Vertex> vertices(BlockKey key) const override {
    return drawer_.blocks().vertex_span(key);
  }
  std::span<const std::uint32_t> indices(BlockKey key) const override {
    return drawer_.blocks().index_span(key);
  }

 protected:
  PatchDrawer drawer_;
};

}  // namespace arete::lod
