#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "arete/lod/bintree/record_pages.h"

namespace arete::lod::bintree {

/// Half a page: a subtree of four generations, or a part of the coarsest ones.
inline constexpr std::size_t kSubtree = kPageRecords / 2;

/// Where the vertices of half a page stand. Either all of one depth, at middle + half * offsets[i],
/// or (offsets empty) of several: ask the domain.
struct HalfPage {
  VertexIndex first = 0;
  bool vacant = false;  ///< no vertex has such an index
  Post middle;
  int half = 0;  ///< cells
  std::span<const Post> offsets;
};
HalfPage half_page(const Domain& domain, VertexIndex first);

/// Calls visit(slot, post) for the places of a page's vertices within the domain, in any order;
/// slot counts records from the page's begin.
template <typename Visit>
void for_each_post(const Domain& domain, std::uint64_t page, const Visit& visit) {
  const auto inside = [&](Post p) {
    return p.col >= 0 && p.row >= 0 && p.col <= domain.side() && p.row <= domain.side();
  };
  for (std::size_t part = 0; part < kPageRecords; part += kSubtree) {
    const HalfPage half = half_page(domain, (page << kLog2PageRecords) + part);
    for (std::size_t i = 0; !half.vacant && i < kSubtree; ++i) {
      if (half.offsets.empty() && !domain.is_vertex(half.first + i)) continue;
      const Post post = half.offsets.empty()
                            ? domain.post_of(half.first + i)
                            : Post{half.middle.col + half.half * half.offsets[i].col,
                                   half.middle.row + half.half * half.offsets[i].row};
      if (inside(post)) visit(part + i, post);
    }
  }
}

/// A page's key in the segment: units in the order they were made, a unit's pages ascending.
inline constexpr int kLog2Pages = 40;
inline std::uint64_t page_key(int unit, std::uint64_t page) {
  return (static_cast<std::uint64_t>(unit) << kLog2Pages) | page;
}
inline std::uint64_t page_of_key(std::uint64_t key) {
  return key & ((std::uint64_t{1} << kLog2Pages) - 1);
}
/// Stands for a page: the block of largest deltas by depth (Codes, depth 0 first) of all that the
/// unit and the units below it hold. That of the last unit is the segment's last block.
inline constexpr std::uint64_t kMaximaPage = (std::uint64_t{1} << kLog2Pages) - 1;

}  // namespace arete::lod::bintree
