#include "arete/lod/bintree/engine_parts.h"

#include <limits>

#include "arete/lod/params.h"

namespace arete::lod::bintree {
Delta delta_param(const Params& params) {
  return choice_param(params, "delta", Delta::Exact,
                      {{"exact", Delta::Exact}, {"incremental", Delta::Incremental}});
}

RecordPages::Options page_options(const Params& params) {
  const auto pages = static_cast<std::size_t>(int_param(params, "pages", 1 << 16, {1, 1 << 28}));
  return {.delta = delta_param(params),
          .budget_bytes = pages * kRecordPageBytes,
          .prefetch = choice_param(params, "prefetch", Prefetch::On,
                                   {{"on", Prefetch::On}, {"off", Prefetch::Off}})};
}

Claims claims_of(const RefineOptions& options, Bounded bounded) {
  const double none = std::numeric_limits<double>::infinity();
  const double tolerance = bounded == Bounded::Yes ? options.tolerance_px : none;
  // An angle is not a distance in the image: under Angular the bound holds on a sphere only.
  const bool in_pixels = options.scale != ErrorScale::Angular;
  return {.conforming = true,
          .error_px = in_pixels ? tolerance : none,
          .pop_px = none,  // a vertex comes or goes at once
          .error_angular_px = in_pixels ? none : tolerance};
}

float error_m(const Findings& found, Bounded bounded) {
  if (bounded == Bounded::No) return std::numeric_limits<float>::infinity();
  const auto late = static_cast<float>(found.late_error_m);
  return std::max(value(found.delta), std::nextafter(late, 2 * late));
}

void report(const Ground& ground, const Findings& found, Bounded bounded, RefineStats& stats) {
  stats.pages_touched = ground.pages().counts().touched;
  stats.pages_read = ground.pages().counts().faults;
  stats.page_bytes = ground.pages().counts().resident_bytes;
  stats.triangles = found.halved + 4;
  stats.visited_nodes = found.visited;
  stats.evaluated_vertices = found.evaluated;
  stats.culled = found.culled;
  stats.late_blocks = found.late;
  stats.full_triangles = ground.full_triangles();
  stats.achieved_error_px = bounded == Bounded::Yes
                                ? std::max(stats.tolerance_px, found.late_error_px)
                                : std::numeric_limits<double>::infinity();
}

}  // namespace arete::lod::bintree
