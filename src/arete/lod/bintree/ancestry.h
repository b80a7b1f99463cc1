#pragma once

#include <array>
#include <cstdint>

#include "arete/core/post.h"
#include "arete/lod/bintree/vertex_index.h"

namespace arete::lod::bintree {

/// The DAG parents of a vertex: the apices of the two triangles whose common base it halves, or of
/// the one at the border of the domain. A vertex may be drawn only where all of them are.
struct Parents {
  std::array<Post, 2> post;
  int count = 0;
};

/// None for the centre and the corners.
inline Parents parents_of(Post v, const Domain& domain) {
  const int side = domain.side();
  Parents out;
  const auto both = static_cast<unsigned>(v.col | v.row | side);
  const auto half = static_cast<int>(both & (~both + 1U));  // the lowest bit
  if (half == side || 2 * half == side) {
    const bool col_mid = (v.col & half) != 0;
    const bool row_mid = (v.row & half) != 0;
    if (half == side || (col_mid && row_mid)) return out;
  }
  const auto add = [&](int dcol, int drow) {
    const Post p{v.col + dcol * half, v.row + drow * half};
    if (p.col < 0 || p.row < 0 || p.col > side || p.row > side) return;
    out.post[static_cast<std::size_t>(out.count++)] = p;
  };
  const bool odd_col = (v.col & half) != 0;
  const bool odd_row = (v.row & half) != 0;
  if (odd_col && odd_row) {  // the other diagonal than the one it halves (METHODS S2)
    const int turn = ((v.col / (2 * half) + v.row / (2 * half)) & 1) == 0 ? -1 : 1;
    add(1, turn);
    add(-1, -turn);
  } else {
    const int along = odd_col ? 1 : 0;
    add(1 - along, along);
    add(along - 1, -along);
  }
  return out;
}

}  // namespace arete::lod::bintree
