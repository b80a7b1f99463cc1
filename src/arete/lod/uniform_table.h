#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "arete/lod/patch_table.h"
#include "arete/lod/uniform_mesh.h"

namespace arete::lod {

/// The "maxerror vertex" of a patch at a level [Wagner2003]: the post of a drawable cell that is
/// furthest from the mesh of that level with uniform diagonals, and where that mesh has it.
struct MaxErrorVertex {
  Post post;
  float z = 0;        ///< metres
  float drawn_z = 0;  ///< metres, on the mesh
  /// Bound on |mesh - height| over every post of the patch, filled ones too; never falls with the
  /// level.
  float bound = 0;
};

/// Of every patch and level 1..w. Read from segment "maxerror-N", N = 2^w + 1.
class UniformTable {
 public:
  /// Throws: NotFound when the store has no such segment, Corrupt.
  UniformTable(const store::Terrain& terrain, const PatchTable& patches);

  /// Requires: 1 <= level <= w.
  const MaxErrorVertex& at(int patch, int level) const {
    return records_[static_cast<std::size_t>(patch) * levels_ + static_cast<std::size_t>(level) -
                    1];
  }
  /// MaxErrorVertex::bound; 0 at level 0.
  double bound(int patch, int level) const { return level == 0 ? 0 : at(patch, level).bound; }
  std::uint64_t bytes() const { return records_.size() * sizeof(MaxErrorVertex); }

 private:
  std::size_t levels_;
  std::vector<MaxErrorVertex> records_;
};

/// "maxerror-17" and so on.
std::string uniform_segment(int log2_cells);
/// Writes it, and the patch table that it goes with.
void write_uniform_tables(const store::Terrain& terrain, store::Writers& writers, int log2_cells);

}  // namespace arete::lod
