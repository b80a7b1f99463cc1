#include "arete/core/georef.h"

namespace arete {

glm::dvec2 Affine2::inverse(glm::dvec2 p) const {
  const double x = p.x - m[2];
  const double y = p.y - m[5];
  const double d = determinant();
  return {(m[4] * x - m[1] * y) / d, (m[0] * y - m[3] * x) / d};
}

}  // namespace arete
