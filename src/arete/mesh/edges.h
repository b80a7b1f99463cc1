#pragma once

#include <cstdint>
#include <vector>

#include "arete/mesh/surface.h"

namespace arete::mesh {

/// A step between neighbouring lattice points of an edge's line, where the surface's boundary
/// runs `net` times from a to b with the surface on its left (seen from above).
struct BoundaryPiece {
  Post a, b;
  int net = 0;
};

/// What the edges of a surface say about it.
struct EdgeReport {
  std::uint64_t flipped = 0, overlaps = 0, t_junctions = 0, height_mismatches = 0;
  std::vector<BoundaryPiece> boundary;  ///< what is left when opposite pieces have cancelled
};

/// Matches directed edges with their opposites, first whole, then cut into primitive lattice
/// pieces. Triangles of zero area take no part.
EdgeReport match_edges(const Surface& surface);

/// Twice the signed area in the plan, in cells; positive when counter-clockwise seen from above.
std::int64_t doubled_area(Post a, Post b, Post c);

}  // namespace arete::mesh
