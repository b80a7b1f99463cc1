#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/core/post.h"

namespace arete::lod {

/// Sides of a square patch, in the order of every per-side array.
enum Side : int { West, North, East, South };
inline constexpr int kSides = 4;
inline constexpr std::array<Side, kSides> kAllSides{West, North, East, South};
inline Side opposite(Side q) {
  return static_cast<Side>((q + 2) % kSides);
}
/// Step to the neighbour across a side, in patches (dx east, dy south).
inline std::pair<int, int> step(Side q) {
  constexpr std::array<std::pair<int, int>, kSides> kSteps{{{-1, 0}, {0, -1}, {1, 0}, {0, 1}}};
  return kSteps[static_cast<std::size_t>(q)];
}

/// A square of cells of one level, as the RTIN triangulates it: `cells` (a power of two) a side,
/// `odd` = the patch's own coarse cell has odd parity (column + row of patches), which turns the
/// diagonal of the coarsest level (METHODS S2).
struct RtinSquare {
  int cells = 1;
  bool odd = false;
  int posts() const { return cells + 1; }
};

/// Local vertex number of grid position (i east, j south): row-major, NW first.
inline std::uint32_t local_vertex(const RtinSquare& square, int i, int j) {
  return static_cast<std::uint32_t>(j * square.posts() + i);
}

/// True when the RTIN diagonal of cell (i, j) runs NW to SE, else NE to SW (METHODS 1.2).
/// `odd` turns the diagonal of the one cell of a square of one cell.
bool diagonal_falls(const RtinSquare& square, int i, int j);

/// Morph parents of local position (i, j), a vertex that the next coarser level lacks (i or j odd):
/// the ends of the coarser RTIN edge that it halves (METHODS S2).
std::pair<std::pair<int, int>, std::pair<int, int>> morph_parents(const RtinSquare& square, int i,
                                                                  int j);

/// Triangles of the square as a list of local vertices, counter-clockwise seen from above. Bit q of
/// `side_mask` set: side q stands one level coarser, its odd vertices are left out (METHODS 4.1).
/// 2 cells^2 triangles less cells/2 for each bit. Requires: side_mask == 0 when cells == 1.
std::vector<std::uint32_t> rtin_triangles(const RtinSquare& square, unsigned side_mask);

/// The same triangles as one strip, sub-strips joined by degenerate triangles [Wagner2003,
/// "Building the Mesh"].
std::vector<std::uint32_t> as_strip(std::span<const std::uint32_t> triangles);

}  // namespace arete::lod
