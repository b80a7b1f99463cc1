#pragma once

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "arete/lod/patch_distances.h"
#include "arete/lod/patch_field.h"
#include "arete/lod/uniform_table.h"

namespace arete::lod {

/// Levels that a method chooses patch by patch, of any difference between neighbours, for patches
/// drawn with a UniformMesh.
///
/// Why error() is a bound. Meshes with uniform diagonals are nested: every triangle of level m is a
/// union of finer ones. So is the band along a side at level m: each of its triangles, and each
/// path on which its posts move, lies within one triangle of the mesh M_m. All its vertices are
/// posts of the patch, or means of such, in that triangle, hence at most bound(m) from M_m, and
/// with them the triangle; the heights are too; so they are at most 2 bound(m) apart. Heights are
/// affine in each factor, so in between the mix of the knots holds.
class UniformField final : public PatchField {
 public:
  /// Where a side stands: at the coarser of its two patches; or there without any morph, and
  /// between patches of one integer level as far as the one further on its way.
  enum class Sides { Coarser, StillButBetweenEquals };

  UniformField(const PatchTable& patches, const UniformTable& table, Sides sides);

  void look_from(glm::dvec3 eye) { distance_.look_from(eye); }
  void set_level(int patch, float level) { level_[static_cast<std::size_t>(patch)] = level; }

  float level(int patch) const override { return level_[static_cast<std::size_t>(patch)]; }
  Standing side(float own, float other, int w) const override;
  double distance(int patch) const override { return distance_[patch]; }
  double error(int patch) const override;
  void raise(std::span<const float> floor_level) override;
  std::uint64_t bytes() const override { return level_.size() * sizeof(float) + distance_.bytes(); }

 private:
  const PatchTable& patches_;
  const UniformTable& table_;
  Sides sides_;
  std::vector<float> level_;
  PatchDistances distance_;
};

/// Reads Params "patch" like parse_patch, with at most 2^UniformMesh::kMostLog2Cells cells.
int parse_uniform_patch(std::string_view text, const store::Manifest& manifest);

/// The real level at which errors reach `allowed`: the coarsest level whose error is at most that,
/// and the share of the way to the next by their two errors, in [0, log2_cells]. error_of(l) is
/// asked for from the coarsest level down to the one found, never for level 0, which has none.
template <typename ErrorOf>
float coarsest_level(int log2_cells, double allowed, const ErrorOf& error_of) {
  double above = 0;
  for (int l = log2_cells; l >= 0; --l) {
    const double error = l == 0 ? 0 : error_of(l);
    if (error > allowed) {
      above = error;
      continue;
    }
    if (l == log2_cells) return static_cast<float>(l);
    // Down to a whole 1/65536, so that it stays below the next level in float.
    const double share = std::floor((allowed - error) / (above - error) * 0x1p16) * 0x1p-16;
    return static_cast<float>(l + std::min(share, 1 - 0x1p-16));
  }
  return 0;
}

}  // namespace arete::lod
