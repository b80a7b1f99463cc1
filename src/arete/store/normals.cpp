#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "arete/store/raster_recipe.h"

namespace arete::store {
namespace {

constexpr std::int32_t kFlatCode = 128;

// Normal direction (x, y) = m (dz/dcol, dz/drow), where the differences are twice the central ones
// in counts: the gradient in the world is the inverse transpose of world_from_post.
struct SlopeMap {
  float xc = 0, xr = 0, yc = 0, yr = 0;
};

SlopeMap slope_map(const Affine2& a, double quantum_m) {
  const double scale = -0.5 * quantum_m / a.determinant();
  return {static_cast<float>(scale * a.m[4]), static_cast<float>(-scale * a.m[3]),
          static_cast<float>(-scale * a.m[1]), static_cast<float>(scale * a.m[0])};
}

// 127.5 + 127.5 sign(v) sqrt(|v|), rounded: encode_normal in float, for v in [-1, 1].
std::int32_t code_of(float v) {
  const float root = std::copysign(std::sqrt(std::abs(v)), v);
  return static_cast<std::int32_t>(128.0F + 127.5F * root);
}

void encode_direction(float x, float y, float z, std::uint8_t* to) {
  const float scale = 1 / std::sqrt(x * x + y * y + z * z);
  to[0] = static_cast<std::uint8_t>(code_of(x * scale));
  to[1] = static_cast<std::uint8_t>(code_of(y * scale));
}

std::int32_t wrapping_difference(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
}

// Masks instead of conditions: with branches the row loop would not become vector code.
std::int32_t mask_if(bool condition) {
  return -static_cast<std::int32_t>(condition);
}

std::int32_t select(std::int32_t mask, std::int32_t a, std::int32_t b) {
  return (a & mask) | (b & ~mask);
}

// Twice the central difference; one-sided where a neighbour is absent, 0 where both are.
float double_difference(std::int32_t before, std::int32_t here, std::int32_t after) {
  const std::int32_t has_before = mask_if(before != kAbsent);
  const std::int32_t has_after = mask_if(after != kAbsent);
  const std::int32_t backward = wrapping_difference(here, before) & has_before;
  const std::int32_t forward = wrapping_difference(after, here) & has_after;
  return static_cast<float>(select(has_after, forward, backward)) +
         static_cast<float>(select(has_before, backward, forward));
}

struct RowTriple {
  const std::int32_t *north, *here, *south;
};

void encode_row(const RowTriple& rows, int count, const SlopeMap& m, std::uint8_t* to) {
  for (int c = 0; c < count; ++c) {
    const std::int32_t here = rows.here[c];
    const float dc = double_difference(rows.here[c - 1], here, rows.here[c + 1]);
    const float dr = double_difference(rows.north[c], here, rows.south[c]);
    const float x = m.xc * dc + m.xr * dr;
    const float y = m.yc * dc + m.yr * dr;
    const float scale = 1 / std::sqrt(x * x + y * y + 1);
    const std::int32_t code_x = code_of(x * scale);
    const std::int32_t code_y = code_of(y * scale);
    const std::int32_t absent = mask_if(here == kAbsent);
    to[2 * c] = static_cast<std::uint8_t>(select(absent, kFlatCode, code_x));
    to[2 * c + 1] = static_cast<std::uint8_t>(select(absent, kFlatCode, code_y));
  }
}

struct DecodedNormals {
  std::array<float, 256> component{};
  DecodedNormals() {
    for (int code = 0; code < 256; ++code) {
      const float root = (static_cast<float>(code) - 127.5F) / 127.5F;
      component[static_cast<std::size_t>(code)] = root * std::abs(root);
    }
  }
};

void mean_normal(const std::array<const std::uint8_t*, 4>& from, std::uint8_t* to) {
  static const DecodedNormals decoded;
  float x = 0;
  float y = 0;
  float z = 0;
  for (const std::uint8_t* code : from) {
    const float nx = decoded.component[code[0]];
    const float ny = decoded.component[code[1]];
    x += nx;
    y += ny;
    z += std::sqrt(std::max(1e-6F, 1 - nx * nx - ny * ny));
  }
  encode_direction(x, y, z, to);
}

}  // namespace

RasterRecipe normals_recipe(const PyramidShape& shape, const Affine2& world_from_post,
                            double quantum_m) {
  RasterRecipe recipe;
  recipe.step = "normals";
  recipe.shape = pyramid_over(shape.cols, shape.rows);
  recipe.shape.channels = 2;
  recipe.shape.fill = static_cast<std::uint8_t>(kFlatCode);
  recipe.apron = 1;
  recipe.make_texels = [map = slope_map(world_from_post, quantum_m)](
                           const HeightPatch& patch, Post post, int cols, std::uint8_t* to) {
    encode_row({patch.counts(post.row - 1, post.col), patch.counts(post.row, post.col),
                patch.counts(post.row + 1, post.col)},
               cols, map, to);
  };
  recipe.mean = mean_normal;
  return recipe;
}

}  // namespace arete::store
