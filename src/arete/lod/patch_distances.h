#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <glm/glm.hpp>

#include "arete/lod/patch_table.h"

namespace arete::lod {

/// How far the eye is from each drawable patch's box, metres.
class PatchDistances {
 public:
  /// `table` must outlive it.
  explicit PatchDistances(const PatchTable& table)
      : table_(table), distance_(static_cast<std::size_t>(table.size())) {}

  /// Measures anew only when the eye has moved.
  void look_from(glm::dvec3 eye);
  double operator[](int patch) const { return distance_[static_cast<std::size_t>(patch)]; }
  std::uint64_t bytes() const { return distance_.size() * sizeof(double); }

 private:
  const PatchTable& table_;
  glm::dvec3 eye_{std::numeric_limits<double>::quiet_NaN()};
  std::vector<double> distance_;
};

}  // namespace arete::lod
