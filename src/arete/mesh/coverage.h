#pragma once

#include <cstdint>
#include <span>

#include "arete/core/heightfield.h"
#include "arete/core/view.h"
#include "arete/mesh/edges.h"

namespace arete::mesh {

/// Cells that a boundary leaves uncovered or encloses more than once.
struct CoverageReport {
  std::uint64_t uncovered_cells = 0;  ///< drawable, required, and not wholly covered
  std::uint64_t overlapped_cells = 0;
};

/// How often each cell is covered follows from the surface's boundary alone (its winding number),
/// exactly and for edges of any slope: whatever lies inside has cancelled.
CoverageReport measure_coverage(std::span<const BoundaryPiece> boundary, const Heightfield& dem,
                                const View* view, int threads);

}  // namespace arete::mesh
