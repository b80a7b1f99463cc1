#pragma once

#include <functional>

#include "arete/lod/bintree/record_pages.h"

namespace arete::lod::bintree {

/// Calls visit(slot, post) for the places of a page's vertices within the domain, in any order;
/// slot counts records from the page's begin.
void for_each_post(const Domain& domain, std::uint64_t page,
                   const std::function<void(std::size_t slot, Post post)>& visit);

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
