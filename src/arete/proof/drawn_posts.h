#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "arete/mesh/surface.h"
#include "arete/proof/reference.h"

namespace arete::proof {

/// Heights at the posts of one reference tile, row-major from its north-west post, rows
/// kTilePosts apart; NaN where nothing is drawn.
using PostHeights = std::array<double, std::size_t{Reference::kTilePosts} * Reference::kTilePosts>;

/// Reads a drawn surface at posts: heights of the float vertices' planes, in double.
/// Lifetime: surface and reference must outlive it. Thread contract: immutable.
class DrawnPosts {
 public:
  /// Sorts the triangles into the given tiles. Cost: O(triangles).
  DrawnPosts(const mesh::Surface& surface, const Reference& reference, std::span<const int> tiles);

  /// The surface at every post of the tile. Where triangles disagree about a post (a T-junction or
  /// an overlap), the height further from the truth. Requires: a tile that the constructor was
  /// given.
  void read(int tile, PostHeights& z) const;

 private:
  std::span<const std::uint32_t> triangles_of(int tile) const;

  const mesh::Surface& surface_;
  const Reference& reference_;
  std::vector<std::uint32_t> first_;      // tile -> first of its triangles; one more at the end
  std::vector<std::uint32_t> triangles_;  // ascending within a tile
};

}  // namespace arete::proof
