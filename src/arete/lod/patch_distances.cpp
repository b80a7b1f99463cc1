#include "arete/lod/patch_distances.h"

namespace arete::lod {

void PatchDistances::look_from(glm::dvec3 eye) {
  if (eye == eye_) return;
  eye_ = eye;
  for (int p = 0; p < table_.size(); ++p) {
    if (!table_.drawable(p)) continue;
    const glm::dvec3 nearest = glm::clamp(eye, table_.box_min(p), table_.box_max(p));
    distance_[static_cast<std::size_t>(p)] = glm::length(eye - nearest);
  }
}

}  // namespace arete::lod
