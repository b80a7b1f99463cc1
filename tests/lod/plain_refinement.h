#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <utility>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/lod/bintree/ground.h"
#include "arete/mesh/surface.h"

#include "lod/recorded_terrain.h"

namespace arete::lod::bintree {

using PostTriangle = std::array<Post, 3>;

inline bool in_order(Post a, Post b) {
  return std::pair(a.row, a.col) < std::pair(b.row, b.col);
}

/// Bisection from the four roots by posts alone: no numbers of vertices, no strip, no planes
/// remembered. Shares with the engines what a record holds and what the criterion says of it.
class PlainRefinement {
 public:
  /// A vertex that is drawn and the ends of the edge that it halves.
  struct Halving {
    Post vertex, left, right;
  };

  PlainRefinement(AllRecords& records, const Ground& ground, const Criterion& criterion, bool cull)
      : records_(records), ground_(ground), criterion_(criterion), cull_(cull) {
    const int n = records.domain().side();
    const std::array<Post, 4> corners{{{0, n}, {n, n}, {n, 0}, {0, 0}}};
    for (std::size_t i = 0; i < 4; ++i) halve({n / 2, n / 2}, corners[i], corners[(i + 1) % 4]);
    for (PostTriangle& t : leaves) std::ranges::sort(t, in_order);
    std::ranges::sort(leaves, [](const PostTriangle& a, const PostTriangle& b) {
      return std::ranges::lexicographical_compare(a, b, in_order);
    });
  }

  std::vector<PostTriangle> leaves;  ///< corners and triangles ascending
  std::vector<Halving> halvings;     ///< once for each triangle halved, ancestors first

 private:
  void halve(Post apex, Post left, Post right) {
    const Post sum{left.col + right.col, left.row + right.row};
    const Post middle{sum.col / 2, sum.row / 2};
    if (sum.col % 2 != 0 || sum.row % 2 != 0 || !is_active(middle)) {
      leaves.push_back({apex, left, right});
      return;
    }
    halvings.push_back({middle, left, right});
    halve(middle, left, apex);
    halve(middle, apex, right);
  }
  bool is_active(Post v) const {
    const Ball ball = ground_.ball(v, records_[v]);
    return criterion_.selected(ball) && (!cull_ || criterion_.lowest(ball) >= -ball.radius);
  }

  AllRecords& records_;
  const Ground& ground_;
  const Criterion& criterion_;
  bool cull_;
};

/// A surface's triangles as PlainRefinement gives them.
inline std::vector<PostTriangle> sorted_triangles(const mesh::Surface& surface) {
  std::vector<PostTriangle> out;
  for (std::size_t i = 0; i + 2 < surface.indices.size(); i += 3) {
    PostTriangle t;
    for (std::size_t k = 0; k < 3; ++k) t[k] = surface.vertices[surface.indices[i + k]].post;
    std::ranges::sort(t, in_order);
    out.push_back(t);
  }
  std::ranges::sort(out, [](const PostTriangle& a, const PostTriangle& b) {
    return std::ranges::lexicographical_compare(a, b, in_order);
  });
  return out;
}

}  // namespace arete::lod::bintree
