#include "arete/lod/bintree/page_layout.h"

#include <array>

namespace arete::lod::bintree {
namespace {

// A subtree of four generations: half a page.
constexpr int kSubtreeBits = 8;
constexpr std::size_t kSubtree = std::size_t{1} << kSubtreeBits;

// Places of a subtree's finest vertices about its root's parent's ... the vertex that
// `kSubtreeBits` bits stand below, in units of half the squares that they halve.
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

bool inside(const Domain& domain, Post p) {
  return p.col >= 0 && p.row >= 0 && p.col <= domain.side() && p.row <= domain.side();
}

}  // namespace

void for_each_post(const Domain& domain, std::uint64_t page,
                   const std::function<void(std::size_t, Post)>& visit) {
  static const Offsets kOffsets = make_offsets();
  for (std::size_t part = 0; part < kPageRecords; part += kSubtree) {
    const VertexIndex first = (page << kLog2PageRecords) + part;
    const VertexIndex root = first >> kSubtreeBits;
    if (first >= domain.index_end()) return;
    if (root < kSouthWest) {  // holds several generations, or gaps
      for (std::size_t i = 0; i < kSubtree && first + i < domain.index_end(); ++i) {
        if (!domain.is_vertex(first + i)) continue;
        const Post post = domain.post_of(first + i);
        if (inside(domain, post)) visit(part + i, post);
      }
      continue;
    }
    if (!domain.is_vertex(root) || root <= kNorthWest) continue;
    const int depth = Domain::depth_of(first);
    const auto& offsets = depth % 2 == 0 ? kOffsets.white : kOffsets.black;
    const int half = domain.side() >> (depth / 2 + 1);
    const Post middle = domain.post_of(root);
    for (std::size_t i = 0; i < kSubtree; ++i) {
      const Post post{middle.col + half * offsets[i].col, middle.row + half * offsets[i].row};
      if (inside(domain, post)) visit(part + i, post);
    }
  }
}

}  // namespace arete::lod::bintree
