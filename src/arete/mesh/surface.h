#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/core/heightfield.h"
#include "arete/core/view.h"

namespace arete::mesh {

/// A vertex as drawn: morph factors applied.
struct SurfaceVertex {
  Post post;
  float dcol = 0, drow = 0;  ///< drawn plan position minus post, in posts
  float z = 0;               ///< metres
};

/// The drawn surface of one frame: triangles of three indices each, counter-clockwise seen from
/// above (x east, y north).
struct Surface {
  std::vector<SurfaceVertex> vertices;
  std::vector<std::uint32_t> indices;
  std::size_t triangles() const { return indices.size() / 3; }
  void clear();
};

/// The vertex under the batch's factors.
SurfaceVertex drawn_vertex(const Vertex& v, const DrawBatch& batch);

/// The vertices and indices that a batch draws, of the list itself or of a block.
std::span<const Vertex> vertices_of(const DrawBatch& batch, const DrawList& list,
                                    const BlockSource& blocks);
std::span<const std::uint32_t> indices_of(const DrawBatch& batch, const DrawList& list,
                                          const BlockSource& blocks);

/// Applies every batch's factors (morphed_z) and expands strips, dropping degenerate triangles
/// (a repeated index). Vertices of one batch are not merged with those of another; vertices that no
/// triangle uses are left out. `out` keeps its memory.
void flatten(const DrawList& list, const BlockSource& blocks, Surface& out);

/// What the integer validator found; all zero (but the counts) for a conforming surface.
struct SurfaceReport {
  std::uint64_t triangles = 0;
  std::uint64_t flipped = 0;   ///< zero or negative area in the plan
  std::uint64_t overlaps = 0;  ///< directed edges used twice, and cells covered more than once
  /// Unit edge pieces matched only by an edge of another length. Triangles of zero area do not
  /// take part, so they cannot hide one.
  std::uint64_t t_junctions = 0;
  std::uint64_t height_mismatches = 0;  ///< shared posts drawn at two places; NaN always counts
  std::uint64_t uncovered_cells = 0;    ///< drawable cells that must be covered and are not
  /// flipped + overlaps + height_mismatches + uncovered_cells.
  std::uint64_t cracks() const;
};

/// Exact check in integers that the surface is one conforming triangulation (METHODS S6).
/// Must be covered: every drawable cell of `dem` when view is null, else every drawable cell whose
/// four posts project inside the view's viewport beyond its near plane. Posts outside the grid
/// (padding) may be drawn.
/// Surfaces that move in the plan (dcol, drow != 0) are checked at their posts.
/// Cost: O(triangles + cells that are not covered).
SurfaceReport check_surface(const Surface& surface, const Heightfield& dem, const View* view,
                            int threads = 1);

}  // namespace arete::mesh
