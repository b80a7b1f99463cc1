#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/lod/rtin.h"
#include "arete/store/terrain.h"

namespace arete::lod {

/// How many levels coarser than the patch each side stands; 0 = at the patch's own level. A side
/// keeps every 2^drop-th of its posts.
using SideDrops = std::array<std::uint8_t, kSides>;

/// Triangles of a patch of `cells` a side (a power of two) with uniform diagonals, NW to SE, as a
/// list of local vertices (RtinSquare's numbers), counter-clockwise seen from above. Along a side
/// with a drop runs a band of adapting triangles, one cell wide, that fans around the posts which
/// the side keeps [Wagner2003, Figure 3; deBoer2000]. Whatever the drops of four neighbours,
/// patches whose shared sides stand at one level conform. Requires: 2^drop <= cells.
std::vector<std::uint32_t> uniform_triangles(int cells, const SideDrops& drops);
/// 2 cells^2 less cells - cells / 2^drop for each side.
std::uint64_t uniform_triangle_count(int cells, const SideDrops& drops);

/// A triangle list as one strip: each triangle goes on from the last edge where it can, else behind
/// degenerate triangles that repeat the last vertex and the next first [Wagner2003, "Building the
/// Mesh"]. In the list's order, unlike as_strip: O(triangles).
std::vector<std::uint32_t> strip_in_order(std::span<const std::uint32_t> triangles);

/// Where the factors of a batch with uniform diagonals stand: the nine of [Wagner2003] as printed.
/// kInterior: tweeningI. side(q): tweeningL, ..R, ..B, ..T. both(q): tweeningA = (1 - tweeningL)
/// tweeningI and the like.
struct UniformSlot {
  static constexpr std::uint8_t kInterior = 0;
  static std::uint8_t side(Side q) { return static_cast<std::uint8_t>(1 + q); }
  static std::uint8_t both(Side q) { return static_cast<std::uint8_t>(5 + q); }
};

/// A patch at one level: the counts of its (cells + 1)^2 posts of that level, row-major.
struct LevelPosts {
  std::span<const std::int32_t> counts;
  int cells = 1;
  int level = 0;
  Post origin;  ///< of the patch's NW corner, level-0 posts
};

/// Fills the vertices of the patch: positions, and what each factor moves them by when the sides
/// stand at `drops` (METHODS 7.2(4), 7.3). A post of odd index goes to the middle of its two
/// neighbours in the next coarser mesh; where such a neighbour lies on a side, to where the side is
/// then, so vertex A carries its own delta to side(q) fully collapsed, and one for both(q).
void uniform_vertices(const LevelPosts& posts, const SideDrops& drops,
                      const store::Manifest& lattice, std::span<Vertex> out);

}  // namespace arete::lod
