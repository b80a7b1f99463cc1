#pragma once

#include <cstdint>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/mesh/surface.h"

namespace arete::proof {

/// How much the triangulation changes from frame to frame: |T_t xor T_t-1| / |T_t|, triangles
/// compared by their posts [METHODS S7].
class Incoherence {
 public:
  /// Takes the next frame; returns its share of triangles changed since the one before, percent
  /// (0 of the first).
  double add(const DrawList& list, const BlockSource& blocks);
  /// Mean over the pairs of frames, percent; 0 before there is a pair.
  double percent() const { return pairs_ == 0 ? 0 : 100 * sum_ / pairs_; }

 private:
  mesh::Surface surface_;
  std::vector<std::uint64_t> now_, before_;
  double sum_ = 0;
  int pairs_ = 0;
  bool first_ = true;
};

}  // namespace arete::proof
