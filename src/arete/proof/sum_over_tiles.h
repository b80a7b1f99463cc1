#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "arete/core/parallel.h"

namespace arete::proof {

/// Calls body(tile, sum) for every tile, on shares of the tiles in parallel, each with a Sum of its
/// own, and merges the sums in order. Requires: Sum is default-constructible and has merge().
template <typename Sum, typename Body>
Sum sum_over_tiles(std::span<const int> tiles, int threads, const Body& body) {
  constexpr std::size_t kShares = 32;  // enough to even out the work, few enough to merge
  const std::size_t shares = std::min(kShares, tiles.size());
  std::vector<Sum> sums(std::max<std::size_t>(shares, 1));
  parallel_for(threads, static_cast<int>(shares), [&](int share) {
    const auto s = static_cast<std::size_t>(share);
    // Neighbouring tiles go to different shares: the dear ones lie together.
    for (std::size_t t = s; t < tiles.size(); t += shares) body(tiles[t], sums[s]);
  });
  for (std::size_t s = 1; s < shares; ++s) sums[0].merge(sums[s]);
  return std::move(sums[0]);
}

}  // namespace arete::proof
