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
  /// Throws: as PatchTable.
  PatchDrawer(const store::Terrain& terrain, int log2_cells, Topology topology);

  const PatchTable& table() const { return table_; }
  LevelField& field() { return field_; }
  const PatchBlocks& blocks() const { return blocks_; }
  Footprint footprint() const;

  /// Finds the patches that the view may see: what the other members speak of until the next call.
  void find_visible(const View& view, const RefineOptions& options, RefineStats& stats);
  /// log(need / cap) of the tighter cap for the field as it stands; <= 0 fits.
  double excess(const Budget& budget) const;
  /// Distance from the eye to the nearest box, metres; infinite when nothing is visible.
  double nearest_m() const;
  /// Draws the field as it stands; where heights are missing, raises it first (and counts).
  void draw(const RefineOptions& options, const ScreenError& error, DrawList& out);

 private:
  unsigned side_mask(int patch) const;
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

/// What LevelField::solve keeps: conforming, the error within the tolerance, and motion of at most
/// 2 tau kappa / (kappa - 1) px per unit of relative motion [METHODS 7.8(9)].
Claims field_claims(const RefineOptions& options, double tolerance_px);

/// An engine whose lists a PatchDrawer fills, within the budget: methods add their claims and,
/// where it is not LevelField::solve, how they choose levels.
class PatchEngine : public Engine {
 public:
  PatchEngine(const store::Terrain& terrain, int log2_cells, Topology topology)
      : drawer_(terrain, log2_cells, topology) {}

  void refine(const View& view, const RefineOptions& options, DrawList& out) override;
  Footprint footprint() const override { return drawer_.footprint(); }
  std::span<const Vertex> vertices(BlockKey key) const override {
    return drawer_.blocks().vertex_span(key);
  }
  std::span<const std::uint32_t> indices(BlockKey key) const override {
    return drawer_.blocks().index_span(key);
  }

 protected:
  /// The tolerance of frames that no cap touches.
  virtual double finest_px(const RefineOptions& options) const { return options.tolerance_px; }
  /// Sets the field for the eye. Where `error` allows more, no level may fall; where it allows
  /// enough, every patch stands at the coarsest.
  virtual void set_levels(glm::dvec3 eye, const ScreenError& error);

  PatchDrawer drawer_;

 private:
  ScreenError coarsen(const View& view, const RefineOptions& options, RefineStats& stats);
};

}  // namespace arete::lod
