#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/lod/patch_mesh.h"
#include "arete/lod/rtin.h"
#include "arete/store/terrain.h"

namespace arete::lod {

/// How many levels coarser than the patch each side stands; 0 = at the patch's own level. A side
/// keeps every 2^drop-th of its posts.
using SideDrops = std::array<std::uint8_t, kSides>;

/// Triangles of a patch of `cells` a side (a power of two) with uniform diagonals, NW to SE, as a
/// list of local vertices (RtinSquare's numbers), counter-clockwise seen from above. Along a side
/// with a drop runs a band of adapting triangles, one cell wide, that fans around the posts which
/// the side keeps [Wagner2003, Figure 3; deBoer2000]. Whatever the drops of four neighbours,
/// patches whose shared sides stand at one level conform. Requires: 2^drop <= cells.
std::vector<std::uint32_t> uniform_triangles(int cells, const SideDrops& drops);
/// 2 cells^2 less cells - cells / 2^drop for each side.
std::uint64_t uniform_triangle_count(int cells, const SideDrops& drops);

/// The same triangles as one strip, never longer than the list: along columns of cells and along
/// bands, with degenerate triangles in between that repeat the last vertex of one and the first of
/// the next [Wagner2003, "Building the Mesh"].
std::vector<std::uint32_t> uniform_strip(int cells, const SideDrops& drops);

/// Where the factors of a batch with uniform diagonals stand: the nine of [Wagner2003] as printed.
/// kInterior: tweeningI. side(q): tweeningL, ..R, ..B, ..T. both(q): tweeningA = (1 - tweeningL)
/// tweeningI and the like.
struct UniformSlot {
  static constexpr std::uint8_t kInterior = 0;
  static std::uint8_t side(Side q) { return static_cast<std::uint8_t>(1 + q); }
  static std::uint8_t both(Side q) { return static_cast<std::uint8_t>(5 + q); }
};

/// Fills the vertices of the patch: positions, and what each factor moves them by when the sides
/// stand at `drops` (METHODS 7.2(4), 7.3). A post of odd index goes to the middle of its two
/// neighbours in the next coarser mesh; where such a neighbour lies on a side, to where the side is
/// then, so vertex A carries its own delta to side(q) fully collapsed, and one for both(q).
void uniform_vertices(const LevelPosts& posts, const SideDrops& drops,
                      const store::Manifest& lattice, std::span<Vertex> out);

/// Patches with uniform diagonals, as one strip or list each; sides stand any number of levels
/// coarser. Requires: patches of at most 2^kMostLog2Cells cells, or index sets outgrow all else.
class UniformMesh final : public PatchMesh {
 public:
  static constexpr int kMostLog2Cells = 6;
  /// Where the posts beside an adapted side morph to: the side as it is drawn, or its stored posts.
  enum class Towards { Drawn, Stored };

  UniformMesh(Topology topology, Towards towards) : topology_(topology), towards_(towards) {}
  Topology topology() const override { return topology_; }
  unsigned index_variants(int cells) const override;
  unsigned index_variant(const PatchStanding& standing, int cells) const override;
  std::vector<std::uint32_t> make_indices(int cells, unsigned index_variant) const override;
  std::uint64_t triangles(int cells, unsigned index_variant) const override;
  unsigned vertex_variant(const PatchStanding& standing) const override;
  void make_vertices(const LevelPosts& posts, unsigned vertex_variant,
                     const store::Manifest& lattice, std::span<Vertex> out) const override;
  void set_factors(const PatchStanding& standing,
                   std::array<float, kFactorCount>& factor) const override;

 private:
  Topology topology_;
  Towards towards_;
};

}  // namespace arete::lod
