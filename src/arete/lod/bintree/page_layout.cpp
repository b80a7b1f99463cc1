#include "arete/lod/bintree/page_layout.h"

#include <array>

namespace arete::lod::bintree {
namespace {

// A subtree of four generations: half a page.
constexpr int kSubtreeBits = kLog2PageRecords - 1;

// Places of a subtree's vertices about the one four generations above them, in units of half the
// squares that they halve.
struct Offsets {
  std::array<Post, kSubtree> white, black;
};

Offsets make_offsets() {
  // The domain of five generations: its finest white vertices are such a subtree, and so are the
  // finest black ones below the western midpoint.
  const Domain domain(5);
  Offsets offsets;
  for (std::size_t i = 0; i < kSubtree; ++i) {
    const Post white = domain.post_of((kCentre << kSubtreeBits) | i);
    const Post black = domain.post_of((kWest << kSubtreeBits) | i);
    offsets.white[i] = {white.col - domain.side() / 2, white.row - domain.side() / 2};
    offsets.black[i] = {black.col, black.row - domain.side() / 2};
  }
  return offsets;
}

}  // namespace

HalfPage half_page(const Domain& domain, VertexIndex first) {
  static const Offsets kOffsets = make_offsets();
  HalfPage half;
  half.first = first;
  const VertexIndex root = first >> kSubtreeBits;
  if (root < kCentre) return half;  // several depths, or gaps between them
  half.vacant = first >= domain.index_end() || !domain.is_vertex(first);
  if (half.vacant) return half;
  const int depth = Domain::depth_of(first);
  half.middle = domain.post_of(root);
  half.half = domain.side() >> (depth / 2 + 1);
  half.offsets = depth % 2 == 0 ? kOffsets.white : kOffsets.black;
  return half;
}

}  // namespace arete::lod::bintree
