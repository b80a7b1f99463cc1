#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "arete/lod/engine.h"
#include "arete/lod/level_field.h"
#include "arete/lod/patch_blocks.h"
#include "arete/lod/patch_table.h"
#include "arete/lod/rtin_mesh.h"

namespace arete::lod {

/// Turns a field of levels into a draw list: culls, fetches blocks, sets the factors. What full,
/// geomipmap and other patch methods share; they differ in the field and in the mesh.
class PatchDrawer {
 public:
  /// Throws: as PatchTable.
  PatchDrawer(const store::Terrain& terrain, int log2_cells, std::unique_ptr<const PatchMesh> mesh);

  const PatchTable& table() const { return table_; }
  const PatchBlocks& blocks() const { return blocks_; }
  Footprint footprint(const PatchField& field) const;

  /// Finds the patches that the view may see: what the other members speak of until the next call.
  void find_visible(const View& view, const RefineOptions& options, RefineStats& stats);
  /// Takes in where the visible patches stand: what excess() and draw() go by.
  void stand(const PatchField& field);
  /// log(need / cap) of the tighter cap; <= 0 fits.
  double excess(const Budget& budget) const;
  /// Distance from the eye to the nearest box, metres; infinite when nothing is visible.
  double nearest_m(const PatchField& field) const;
  /// Draws the field as taken in; where heights are missing, raises it first (and counts).
  void draw(PatchField& field, const RefineOptions& options, const ScreenError& error,
            DrawList& out);

 private:
  PatchStanding standing(const PatchField& field, int patch) const;
  void fetch_blocks(PatchField& field, const RefineOptions& options, RefineStats& stats);
  bool fetch_missing(const RefineOptions& options, RefineStats& stats);
  void emit(const PatchField& field, std::size_t visible, const ScreenError& error, DrawList& out);

  const store::Terrain& terrain_;
  Affine2 world_from_post_;
  PatchTable table_;
  PatchBlocks blocks_;
  glm::dvec3 box_min_{0}, box_max_{0};
  std::vector<int> visible_;
  std::vector<PatchStanding> at_;   ///< of visible_
  std::vector<BlockKey> keys_;      ///< of visible_
  std::vector<float> floor_level_;  ///< finest level whose heights are there
  std::vector<TileId> wanted_;      ///< for prefetch
};

/// An engine whose lists a PatchDrawer fills, within the budget: methods add their claims and how
/// they choose levels.
class PatchEngine : public Engine {
 public:
  PatchEngine(const store::Terrain& terrain, int log2_cells, std::unique_ptr<const PatchMesh> mesh)
      : drawer_(terrain, log2_cells, std::move(mesh)) {}

  void refine(const View& view, const RefineOptions& options, DrawList& out) override;
  Footprint footprint() const override { return drawer_.footprint(field()); }
  std::span<const Vertex> vertices(BlockKey key) const override {
    return drawer_.blocks().vertex_span(key);
  }
  std::span<const std::uint32_t> indices(BlockKey key) const override {
    return drawer_.blocks().index_span(key);
  }

 protected:
  /// The tolerance of frames that no cap touches.
  virtual double finest_px(const RefineOptions& options) const { return options.tolerance_px; }
  virtual PatchField& field() = 0;
  virtual const PatchField& field() const = 0;
  /// Sets the field for the view, by what `error` allows or, where a method does not go by that, by
  /// `tolerance_px`: they grow together. Where they allow more, no level may fall; where they allow
  /// enough, every patch stands at the coarsest. Returns how many errors it looked at.
  virtual std::uint64_t set_levels(const View& view, const ScreenError& error,
                                   double tolerance_px) = 0;
  /// The tolerance that levels so set keep.
  virtual double kept_px(const ScreenError& error, double) const {
    return error.tolerance_px(drawer_.nearest_m(field()));
  }

  PatchDrawer drawer_;

 private:
  ScreenError coarsen(const View& view, const RefineOptions& options, RefineStats& stats);
};

/// What LevelField::solve keeps: conforming, the error within the tolerance, and motion of at most
/// 2 tau kappa / (kappa - 1) px per unit of relative motion [METHODS 7.8(9)].
Claims field_claims(const RefineOptions& options, double tolerance_px);

/// A patch engine with the RTIN's diagonals, whose levels LevelField chooses.
class LevelFieldEngine : public PatchEngine {
 public:
  LevelFieldEngine(const store::Terrain& terrain, int log2_cells, Topology topology)
      : PatchEngine(terrain, log2_cells, std::make_unique<RtinMesh>(topology)),
        field_(drawer_.table(), terrain.manifest().quantum_m) {}

 protected:
  LevelField& field() final { return field_; }
  const LevelField& field() const final { return field_; }
  std::uint64_t set_levels(const View& view, const ScreenError& error, double) override {
    field_.solve(view.eye, error);
    return static_cast<std::uint64_t>(drawer_.table().size());
  }

 private:
  LevelField field_;
};

}  // namespace arete::lod
