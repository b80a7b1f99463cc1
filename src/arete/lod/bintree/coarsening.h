#pragma once

#include "arete/lod/bintree/walk.h"

namespace arete::lod::bintree {

/// What drawing so many halved triangles takes of either method, at most.
struct Need {
  std::uint64_t halved = 0;
  std::uint64_t triangles() const { return halved + 4; }
  /// A vertex for every triangle visited and the five first; three indices a triangle drawn.
  std::uint64_t vertex_bytes() const {
    return sizeof(Vertex) * (2 * halved + 4 + 5) + 3 * sizeof(std::uint32_t) * triangles();
  }
  Budget budget() const { return {triangles(), vertex_bytes()}; }
  bool fits(const Budget& budget) const {
    return triangles() <= budget.triangles && vertex_bytes() <= budget.vertex_bytes;
  }
};

/// What the coarsest surface needs.
inline Budget least_budget() {
  return Need{}.budget();
}

/// What the view asks for, before a budget.
ScreenError asked_error(const View& view, const RefineOptions& options);
/// The finest error, to 0.1 %, under which the view's triangles fit the budget. The same for the
/// same ground and view, whoever asks. `sharper`: of the Criterion that will be drawn by.
/// Cost: some eight walks.
ScreenError fitting_error(Ground& ground, const View& view, const RefineOptions& options,
                          double sharper = 1);
/// The tolerance in pixels that the error keeps over the ground.
double kept_tolerance_px(const Ground& ground, const View& view, const ScreenError& error);

}  // namespace arete::lod::bintree
