#pragma once

#include <array>
#include <cassert>
#include <cstdint>

#include "arete/core/post.h"

namespace arete::lod::bintree {

/// Number of a vertex in interleaved-quadtree order [LindstromPascucci2002]: two families of
/// quadtrees, *white* vertices (square centres, one tree) and *black* ones (midpoints of square
/// sides, four trees), children of p at 4p .. 4p + 3.
///
/// The paper's general form is c = 4p + ((2p + g + 1 + m) mod 4) + m. Deviation: m = 0 where the
/// paper packs with m = -7. A number is then its root's, followed by two bits a generation, so
/// subtrees fill aligned ranges: pages hold whole subtrees, and a page that holds none of the grid
/// (gaps between generations, "ghosts" outside the square) is not stored.
using VertexIndex = std::uint64_t;

/// The roots: centre, midpoints of the four sides; then the corners, which have no children.
inline constexpr VertexIndex kCentre = 3, kWest = 4, kSouth = 5, kEast = 6, kNorth = 7;
inline constexpr VertexIndex kSouthWest = 8, kSouthEast = 9, kNorthEast = 10, kNorthWest = 11;

/// The bisection step. Triangle (apex p, base from l to r); g bisects its base. The halves are the
/// left one (apex g, base from l to p), whose base left_child(p, g) bisects, and the right one
/// (apex g, base from p to r), right_child(p, g). The winding turns with every step: triangles p,
/// l, r whose base vertex has odd depth run counter-clockwise seen from above, the others
/// clockwise.
inline VertexIndex left_child(VertexIndex p, VertexIndex g) {
  return 4 * p + ((2 * p + g + 1) & 3U);
}
inline VertexIndex right_child(VertexIndex p, VertexIndex g) {
  return 4 * p + ((2 * p + g + 2) & 3U);
}

/// One of the four triangles that the square is cut into: apex kCentre, base from left to right,
/// bisected by middle; counter-clockwise.
struct RootTriangle {
  VertexIndex middle, left, right;
};
/// South, east, north, west: the order of SOAR's strip.
inline constexpr std::array<RootTriangle, 4> kRootTriangles{{{kSouth, kSouthWest, kSouthEast},
                                                             {kEast, kSouthEast, kNorthEast},
                                                             {kNorth, kNorthEast, kNorthWest},
                                                             {kWest, kNorthWest, kSouthWest}}};

/// The square of 2^log2_cells cells a side that holds a grid, its NW post at the grid's (0, 0).
/// *Depth* counts bisections: the centre has 0, the side midpoints 1, and so on; even depths are
/// white, odd ones black; the finest is depths() - 1. Vertices of depths 2d and 2d + 1 halve
/// squares of side() >> d cells.
class Domain {
 public:
  /// Requires: 1 <= log2_cells <= kMaxLog2Cells.
  explicit Domain(int log2_cells) : k_(log2_cells) { assert(k_ >= 1 && k_ <= kMaxLog2Cells); }
  /// The smallest over cols x rows posts, at least 2 cells a side.
  /// Throws: Limit where it does not fit; who knows the terrain's name asks fits() first.
  static Domain over(int cols, int rows);
  /// At most 2^kMaxLog2Cells cells a side.
  static bool fits(int cols, int rows);

  static constexpr int kMaxLog2Cells = 20;
  int log2_cells() const { return k_; }
  int side() const { return 1 << k_; }  ///< cells; posts 0 .. side()
  int depths() const { return 2 * k_; }
  /// Every index is below this; most numbers below it name a vertex or a ghost.
  VertexIndex index_end() const { return k_ == 1 ? 12 : VertexIndex{2} << (2 * k_); }

  /// The vertex's number. Requires: 0 <= col, row <= side(). Cost: log2_cells steps.
  VertexIndex index_of(Post post) const;
  /// Its place; a ghost's lies outside the square. Requires: an index that is_vertex.
  Post post_of(VertexIndex index) const;
  /// False in the gaps between generations. Ghosts are vertices.
  bool is_vertex(VertexIndex index) const;
  /// Depth of a vertex; -1 for the corners.
  static int depth_of(VertexIndex index);

 private:
  int k_;
};

}  // namespace arete::lod::bintree
