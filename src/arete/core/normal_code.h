#pragma once

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

namespace arete {

/// RG8 code of an upward unit normal: each of x (east) and y (north) as
/// 127.5 + 127.5 sign(v) sqrt(|v|), rounded. The square root spends the codes near flat ground,
/// where shading shows steps: 1/16,000 there, 1/64 at the horizon. Exact at 0 is code 127 or 128
/// within 2e-5.
std::array<std::uint8_t, 2> encode_normal(glm::dvec3 n);
glm::dvec3 decode_normal(std::uint8_t r, std::uint8_t g);

}  // namespace arete
