#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "arete/lod/patch_mesh.h"

namespace arete::lod {

/// Where each factor of a batch stands (METHODS 7.3, DESIGN 3): the nine of [Wagner2003] in product
/// form, with the side factor told apart by whether the side stands at the patch's own level (a) or
/// one coarser (b); c = tI b.
struct PatchSlot {
  static constexpr std::uint8_t kInterior = 0;
  static std::uint8_t own(Side q) { return static_cast<std::uint8_t>(1 + q); }
  static std::uint8_t coarser(Side q) { return static_cast<std::uint8_t>(5 + q); }
  static std::uint8_t product(Side q) { return static_cast<std::uint8_t>(9 + q); }
};

/// Fills the vertices of a patch standing at a level, from the counts of its (cells + 1)^2 posts of
/// that level: positions, and what each factor moves them by.
void make_patch_vertices(const RtinSquare& square, std::span<const std::int32_t> counts,
                         Post origin, int level, const store::Manifest& lattice,
                         std::span<Vertex> out);

/// Patches with the RTIN's diagonals, whose sides stand at most one level coarser: exact morphs.
class RtinMesh final : public PatchMesh {
 public:
  explicit RtinMesh(Topology topology) : topology_(topology) {}
  Topology topology() const override { return topology_; }
  /// The side mask; the two diagonals of a patch of one cell.
  unsigned index_variants(int cells) const override { return cells == 1 ? 2 : 16; }
  unsigned index_variant(const PatchStanding& standing, int cells) const override;
  std::vector<std::uint32_t> make_indices(int cells, unsigned index_variant) const override;
  std::uint64_t triangles(int cells, unsigned index_variant) const override;
  unsigned vertex_variant(const PatchStanding&) const override { return 0; }
  void make_vertices(const LevelPosts& posts, unsigned vertex_variant,
                     const store::Manifest& lattice, std::span<Vertex> out) const override;
  void set_factors(const PatchStanding& standing,
                   std::array<float, kFactorCount>& factor) const override;

 private:
  Topology topology_;
};

}  // namespace arete::lod
