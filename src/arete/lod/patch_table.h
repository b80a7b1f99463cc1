#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "arete/core/build_context.h"
#include "arete/lod/rtin.h"
#include "arete/store/build.h"
#include "arete/store/terrain.h"

namespace arete::lod {

/// The terrain cut into square patches of 2^w cells that share border posts, and what each must
/// know while it is not drawn: its box, four corner heights and error tables. Read from segment
/// "tables-N", N = 2^w + 1, which every patch method shares.
class PatchTable {
 public:
  /// Throws: NotFound when the store has no such segment, Corrupt.
  PatchTable(const store::Terrain& terrain, int log2_cells);

  int log2_cells() const { return w_; }
  int cells() const { return 1 << w_; }
  int cols() const { return cols_; }  ///< patches west to east
  int rows() const { return rows_; }
  int size() const { return cols_ * rows_; }
  int index(int x, int y) const { return y * cols_ + x; }
  int x(int patch) const { return patch % cols_; }
  int y(int patch) const { return patch / cols_; }
  /// Neighbour across a side; -1 at the edge or where that patch is not drawable.
  int neighbour(int patch, Side q) const;

  /// False: no cell of the patch is drawable; it is never drawn and has no tables.
  bool drawable(int patch) const { return drawable_[at(patch)] != 0; }
  /// Box of everything the patch can draw, metres, world.
  glm::dvec3 box_min(int patch) const { return box_min_[at(patch)]; }
  glm::dvec3 box_max(int patch) const { return box_max_[at(patch)]; }
  /// Lattice counts of the corners NW, NE, SW, SE.
  const std::array<std::int32_t, 4>& corners(int patch) const { return corners_[at(patch)]; }

  /// uniform[l], l = 0..w, metres: bound on |surface - height| of the patch at level l.
  const float* uniform(int patch) const { return &uniform_[at(patch) * knots()]; }
  /// side[m], m = 0..w, metres: the same for the band along side q standing at level m.
  const float* side(int patch, Side q) const {
    return &side_[(at(patch) * kSides + static_cast<std::size_t>(q)) * knots()];
  }
  std::size_t knots() const { return static_cast<std::size_t>(w_) + 1; }
  std::uint64_t bytes() const;

 private:
  static std::size_t at(int patch) { return static_cast<std::size_t>(patch); }
  void read(int patch, const std::byte* record);

  int w_, cols_, rows_;
  double quantum_ = 0, offset_ = 0;
  Affine2 world_from_post_;
  std::vector<std::uint8_t> drawable_;
  std::vector<glm::dvec3> box_min_, box_max_;
  std::vector<std::array<std::int32_t, 4>> corners_;
  std::vector<float> uniform_, side_;
};

/// "tables-17" and so on.
std::string tables_segment(int log2_cells);
/// Patch size by terrain size: see geomipmap/README.md, "Patch size".
int default_log2_cells(const store::Manifest& manifest);
/// Reads Params "patch" (posts a side, or "auto"); throws Usage.
int parse_patch(std::string_view text, const store::Manifest& manifest);
/// Writes tables_segment(log2_cells) with error_tables.h.
void write_patch_table(const store::Terrain& terrain, store::Writers& writers, int log2_cells);

}  // namespace arete::lod
