#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/lod/rtin.h"
#include "arete/store/terrain.h"

namespace arete::lod {

/// A real level in [0, w]: the integer level drawn and the share of the way to the next coarser.
struct Standing {
  int level = 0;
  float t = 0;
  Standing() = default;
  Standing(float lambda, int w)
      : level(std::min(static_cast<int>(lambda), w)), t(lambda - static_cast<float>(level)) {}
};

/// Where a patch and its sides stand; a side never finer than the patch.
struct PatchStanding {
  Standing own;
  std::array<Standing, kSides> side;
  bool odd = false;  ///< RtinSquare::odd
};

/// A patch at one level: the counts of its (cells + 1)^2 posts of that level, row-major.
struct LevelPosts {
  std::span<const std::int32_t> counts;
  int cells = 1;
  int level = 0;
  Post origin;  ///< of the patch's NW corner, level-0 posts
  bool odd = false;
};

/// How patches are triangulated and how their vertices move: what tells patch methods apart but for
/// the levels that they choose. Immutable.
class PatchMesh {
 public:
  virtual ~PatchMesh() = default;
  virtual Topology topology() const = 0;

  /// How many index sets a patch of `cells` a side may have, and which of them this standing asks
  /// for.
  virtual unsigned index_variants(int cells) const = 0;
  virtual unsigned index_variant(const PatchStanding& standing, int cells) const = 0;
  virtual std::vector<std::uint32_t> make_indices(int cells, unsigned index_variant) const = 0;
  virtual std::uint64_t triangles(int cells, unsigned index_variant) const = 0;

  /// Tells the vertex blocks of one patch and level apart; below 2^15.
  virtual unsigned vertex_variant(const PatchStanding& standing) const = 0;
  /// Positions, and what each factor moves them by.
  virtual void make_vertices(const LevelPosts& posts, unsigned vertex_variant,
                             const store::Manifest& lattice, std::span<Vertex> out) const = 0;
  virtual void set_factors(const PatchStanding& standing,
                           std::array<float, kFactorCount>& factor) const = 0;
};

}  // namespace arete::lod
