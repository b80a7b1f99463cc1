#include "arete/mesh/coverage.h"
#include "arete/mesh/edges.h"
#include "arete/mesh/surface.h"

namespace arete::mesh {

std::uint64_t SurfaceReport::cracks() const {
  return flipped + overlaps + height_mismatches + uncovered_cells;
}

SurfaceReport check_surface(const Surface& surface, const Heightfield& dem, const View* view,
                            int threads) {
  const EdgeReport edges = match_edges(surface);
  const CoverageReport coverage = measure_coverage(edges.boundary, dem, view, threads);
  return {.triangles = surface.triangles(),
          .flipped = edges.flipped,
          .overlaps = edges.overlaps + coverage.overlapped_cells,
          .t_junctions = edges.t_junctions,
          .height_mismatches = edges.height_mismatches,
          .uncovered_cells = coverage.uncovered_cells};
}

}  // namespace arete::mesh
