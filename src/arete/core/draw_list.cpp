#include "arete/core/draw_list.h"

namespace arete {

void DrawList::clear() {
  batches.clear();
  vertices.clear();
  indices.clear();
  uploads.clear();
  stats = {};
}

float morphed_z(const Vertex& v, const std::array<float, kFactorCount>& factor) {
  float z = v.z;
  for (std::size_t k = 0; k < v.dz.size(); ++k) {
    if (v.slot[k] < kFactorCount) z += v.dz[k] * factor[v.slot[k]];
  }
  return z;
}

}  // namespace arete
