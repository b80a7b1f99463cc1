#pragma once

#include <limits>
#include <memory>

#include "arete/lod/patch_drawer.h"
#include "arete/lod/uniform_field.h"

namespace arete::lod {

/// A patch engine with uniform diagonals that chooses each patch's level by itself: conforming, but
/// neither error nor motion is promised.
class UniformEngine : public PatchEngine {
 public:
  UniformEngine(const store::Terrain& terrain, int log2_cells,
                std::unique_ptr<const UniformMesh> mesh, UniformField::Sides sides)
      : PatchEngine(terrain, log2_cells, std::move(mesh)),
        table_(terrain, drawer_.table()),
        field_(drawer_.table(), table_, sides) {}

  Claims claims(const RefineOptions&) const override {
    const double none = std::numeric_limits<double>::infinity();
    return {.conforming = true, .error_px = none, .pop_px = none, .error_angular_px = none};
  }
  Footprint footprint() const override {
    Footprint f = PatchEngine::footprint();
    f.table_bytes += table_.bytes();
    return f;
  }

 protected:
  UniformField& field() final { return field_; }
  const UniformField& field() const final { return field_; }
  const UniformTable& table() const { return table_; }
  double kept_px(const ScreenError&, double tolerance_px) const override { return tolerance_px; }

 private:
  UniformTable table_;
  UniformField field_;
};

}  // namespace arete::lod
