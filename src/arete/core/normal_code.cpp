#include "arete/core/normal_code.h"

#include <algorithm>
#include <cmath>

namespace arete {
namespace {

std::uint8_t encode_component(double v) {
  const double root = std::copysign(std::sqrt(std::min(1.0, std::abs(v))), v);
  return static_cast<std::uint8_t>(std::clamp(127.5 + 127.5 * root + 0.5, 0.0, 255.0));
}

double decode_component(std::uint8_t code) {
  const double root = (code - 127.5) / 127.5;
  return root * std::abs(root);
}

}  // namespace

std::array<std::uint8_t, 2> encode_normal(glm::dvec3 n) {
  return {encode_component(n.x), encode_component(n.y)};
}

glm::dvec3 decode_normal(std::uint8_t r, std::uint8_t g) {
  const double x = decode_component(r);
  const double y = decode_component(g);
  return glm::normalize(glm::dvec3(x, y, std::sqrt(std::max(1e-6, 1 - x * x - y * y))));
}

}  // namespace arete
