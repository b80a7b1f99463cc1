#include "arete/render/tint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace arete::render {
namespace {

struct Stop {
  double at;
  glm::dvec3 rgb;  // display values, 0..255
};

constexpr std::array<Stop, 8> kLand{{{0.00, {72, 88, 60}},
                                     {0.12, {96, 108, 70}},
                                     {0.28, {138, 132, 90}},
                                     {0.44, {156, 136, 100}},
                                     {0.58, {130, 110, 90}},
                                     {0.72, {122, 114, 108}},
                                     {0.83, {194, 195, 197}},
                                     {0.92, {240, 244, 250}}}};
constexpr std::array<Stop, 4> kSea{
    {{0.00, {10, 24, 58}}, {0.55, {18, 56, 104}}, {0.90, {46, 108, 146}}, {1.00, {98, 158, 172}}}};

constexpr std::array<Stop, 5> kMars{{{0.00, {92, 62, 50}},
                                     {0.30, {142, 90, 62}},
                                     {0.55, {176, 122, 84}},
                                     {0.80, {200, 158, 120}},
                                     {1.00, {226, 204, 180}}}};
constexpr std::array<Stop, 4> kMoon{{{0.00, {78, 78, 82}},
                                     {0.35, {112, 111, 111}},
                                     {0.70, {156, 154, 150}},
                                     {1.00, {206, 204, 200}}}};

std::span<const Stop> ramp(Body body) {
  if (body == Body::Mars) return kMars;
  if (body == Body::Airless) return kMoon;
  return kLand;
}

glm::dvec3 colour_at(std::span<const Stop> stops, double t) {
  t = std::clamp(t, stops.front().at, stops.back().at);
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

// A hash of the lattice point, 0..1.
double lattice(int x, int y, int cells) {
  const auto period = static_cast<std::uint32_t>(cells);
  std::uint32_t h = static_cast<std::uint32_t>(x) % period * 374761393U +
                    static_cast<std::uint32_t>(y) % period * 668265263U + period * 2246822519U;
  h = (h ^ (h >> 15U)) * 2246822519U;
  h = (h ^ (h >> 13U)) * 3266489917U;
  return static_cast<double>(h >> 8U) / (1U << 24U);
}

double value_noise(double x, double y, int cells) {
  const int i = static_cast<int>(x);
  const int j = static_cast<int>(y);
  const double u = glm::smoothstep(0.0, 1.0, x - i);
  const double v = glm::smoothstep(0.0, 1.0, y - j);
  return glm::mix(glm::mix(lattice(i, j, cells), lattice(i + 1, j, cells), u),
                  glm::mix(lattice(i, j + 1, cells), lattice(i + 1, j + 1, cells), u), v);
}

std::uint8_t grain_at(int x, int y) {
  double sum = 0;
  double weight = 1;
  for (int cells = 16; cells <= 128; cells *= 2, weight *= 0.85) {
    const double scale = static_cast<double>(cells) / kGrainSize;
    sum += weight * (value_noise(x * scale, y * scale, cells) - 0.5);
  }
  return static_cast<std::uint8_t>(std::clamp(127.5 + 110 * sum, 0.0, 255.0));
}

}  // namespace

Tint make_tint(Body body, double z_min, double z_max) {
  const double range = std::max(z_max - z_min, 1e-9);
  const bool has_sea = body == Body::Earth && z_min < 0 && z_max > 0;
  const double sea = has_sea ? -z_min / range : 0;
  const double top = body == Body::Earth ? top_of_ramp(z_max) : 1;
  std::vector<std::uint8_t> texels;
  for (int i = 0; i < kTintTexels; ++i) {
    const double t = (i + 0.5) / kTintTexels;
    const glm::dvec3 c = has_sea && t < sea ? colour_at(kSea, t / sea)
                                            : colour_at(ramp(body), (t - sea) / (1 - sea) * top);
    for (int k = 0; k < 3; ++k) texels.push_back(static_cast<std::uint8_t>(std::lround(c[k])));
    texels.push_back(255);
  }
  Tint tint{make_texture(GL_TEXTURE_1D), has_sea ? static_cast<float>(sea) : -1.0F};
  const GLuint name = tint.texture.get();
  glTextureStorage1D(name, 1, GL_SRGB8_ALPHA8, kTintTexels);
  glTextureSubImage1D(name, 0, 0, kTintTexels, GL_RGBA, GL_UNSIGNED_BYTE, texels.data());
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  return tint;
}

GlTexture make_grain() {
  std::vector<std::uint8_t> texels;
  for (int y = 0; y < kGrainSize; ++y) {
    for (int x = 0; x < kGrainSize; ++x) texels.push_back(grain_at(x, y));
  }
  GlTexture texture = make_texture(GL_TEXTURE_2D);
  const GLuint name = texture.get();
  glTextureStorage2D(name, 9, GL_R8, kGrainSize, kGrainSize);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(name, 0, 0, 0, kGrainSize, kGrainSize, GL_RED, GL_UNSIGNED_BYTE,
                      texels.data());
  glGenerateTextureMipmap(name);
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return texture;
}

}  // namespace arete::render
