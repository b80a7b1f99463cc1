#pragma once

#include <vector>

#include "arete/lod/bintree/post_rows.h"
#include "arete/lod/bintree/record_grid.h"

namespace arete::lod::bintree {

/// Each vertex's own delta in lattice counts, before saturation: for every post of the grid's
/// region. 0 means that its triangles are level or hold no post that counts, and no rounding can
/// part them from the posts.
using OwnDeltas = std::vector<double>;

/// Raises `own` by the exact deltas (METHODS 1.4) that these posts give: the greatest distance of a
/// post from the plane of its triangle, for all triangles of the grid's levels that lie in its
/// region with all corners. Rows of a terrain may come in any order and pieces. Exact: counts and
/// planes are doubles without rounding.
void raise_exact(const RecordGrid& grid, const PostRows& posts, OwnDeltas& own);

/// The papers' measure: the vertex's distance from the middle of its base edge.
void raise_incremental(const RecordGrid& grid, OwnDeltas& own);

}  // namespace arete::lod::bintree
