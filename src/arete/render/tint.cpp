#include "arete/render/tint.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace arete::render {
namespace {

constexpr int kTexels = 1024;

struct Stop {
  double at;
  glm::dvec3 rgb;  // display values, 0..255
};

constexpr std::array<Stop, 8> kLand{{{0.00, {84, 112, 68}},
                                     {0.12, {112, 134, 78}},
                                     {0.30, {160, 158, 100}},
                                     {0.46, {172, 150, 102}},
                                     {0.62, {142, 118, 90}},
                                     {0.78, {134, 122, 112}},
                                     {0.90, {196, 194, 192}},
                                     {1.00, {246, 248, 251}}}};
constexpr std::array<Stop, 4> kSea{
    {{0.00, {18, 36, 78}}, {0.55, {30, 74, 128}}, {0.90, {70, 134, 172}}, {1.00, {136, 188, 200}}}};

glm::dvec3 colour_at(std::span<const Stop> stops, double t) {
  t = std::clamp(t, 0.0, 1.0);
  std::size_t i = 1;
  while (i + 1 < stops.size() && stops[i].at < t) ++i;
  const Stop& a = stops[i - 1];
  const Stop& b = stops[i];
  return glm::mix(a.rgb, b.rgb,
                  glm::smoothstep(a.at, b.at, t) * 0.5 + (t - a.at) / (b.at - a.at) * 0.5);
}

// Hills have no snow line: the ramp ends in rock unless the land is high.
double top_of_ramp(double z_max) {
  return 0.66 + 0.34 * glm::smoothstep(900.0, 2600.0, z_max);
}

}  // namespace

Tint make_tint(double z_min, double z_max) {
  const double range = std::max(z_max - z_min, 1e-9);
  const bool has_sea = z_min < 0 && z_max > 0;
  const double sea = has_sea ? -z_min / range : 0;
  const double top = top_of_ramp(z_max);
  std::vector<std::uint8_t> texels;
  for (int i = 0; i < kTexels; ++i) {
    const double t = (i + 0.5) / kTexels;
    const glm::dvec3 c = has_sea && t < sea ? colour_at(kSea, t / sea)
                                            : colour_at(kLand, (t - sea) / (1 - sea) * top);
    for (int k = 0; k < 3; ++k) texels.push_back(static_cast<std::uint8_t>(c[k] + 0.5));
    texels.push_back(255);
  }
  Tint tint{make_texture(GL_TEXTURE_1D), has_sea ? static_cast<float>(sea) : -1.0F};
  const GLuint name = tint.texture.get();
  glTextureStorage1D(name, 1, GL_SRGB8_ALPHA8, kTexels);
  glTextureSubImage1D(name, 0, 0, kTexels, GL_RGBA, GL_UNSIGNED_BYTE, texels.data());
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  return tint;
}

}  // namespace arete::render
