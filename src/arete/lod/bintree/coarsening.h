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

/// The finest error, to 0.1 %, under which the view's triangles fit the budget. The same for the
/// same ground and view, whoever asks. `sharper`: of the Criterion that will be drawn by.
/// Cost: some eight walks.
ScreenError fitting_error(Ground& ground, const View& view, const RefineOptions& options,
                          double sharper = 1);
/// The tolerance in pixels that the error keeps over the ground.
double kept_tolerance_px(const Ground& ground, const View& view, const ScreenError& error);

/// Draws every frame by the error asked for or, where a budget does not allow it, by the finest
/// that fits.
class FittedDrawing {
 public:
  /// `ground` must outlive it. `sharper`: as of fitting_error.
  explicit FittedDrawing(Ground& ground, double sharper = 1) : ground_(ground), sharper_(sharper) {}

  /// `draw(error)` draws and says what it found; its last call is the frame's. Sets the tolerance
  /// that the frame keeps.
  template <typename Draw>
  Findings operator()(const View& view, const RefineOptions& options, RefineStats& stats,
                      Draw draw) {
    const ScreenError asked(view, options.tolerance_px, options.scale);
    // A frame that a budget bound is likely followed by another.
    ScreenError error = bound_ ? fitting_error(ground_, view, options, sharper_) : asked;
    Findings found = draw(error);
    if (!bound_ && !Need{found.halved}.fits(options.budget)) {
      error = fitting_error(ground_, view, options, sharper_);
      found = draw(error);
    }
    // The fit counts by pages; what is drawn may know more than is resident. Ever more times the
    // fitted error: only many times reach what is near (ScreenError::coarser).
    const ScreenError fitted = error;
    for (double times = kCoarser; !Need{found.halved}.fits(options.budget); times *= kCoarser) {
      error = fitted.coarser(times);
      found = draw(error);
    }
    bound_ = error.allowed_m(1) != asked.allowed_m(1);
    stats.tolerance_px = bound_ ? kept_tolerance_px(ground_, view, error) : options.tolerance_px;
    return found;
  }

 private:
  static constexpr double kCoarser = 1.25;

  Ground& ground_;
  double sharper_;
  bool bound_ = false;
};

}  // namespace arete::lod::bintree
