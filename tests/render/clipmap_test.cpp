#include "arete/render/clipmap.h"

#include <cmath>

#include "render/gl_test.h"
#include "render/toy_land.h"

namespace arete::render {
namespace {

constexpr int kTile = 16;

class ClipmapTest : public GlTest {};

std::uint8_t code(int level, int x, int y, int) {
  return static_cast<std::uint8_t>((x * 7 + y * 13 + level * 31) & 255);
}

// Texels that the shader may sample around the camera but that the array does not hold.
int wrong_texels(const Clipmap& map, const ToyRaster& source, glm::ivec2 post) {
  const RasterShape shape = source.shape();
  const ClipBlock b = map.block(post);
  const auto first = static_cast<int>(b.levels.x);
  const glm::ivec2 size(std::lround(1 / b.scale.z), std::lround(1 / b.scale.w));
  const int layers = shape.levels - first;
  std::vector<std::uint8_t> texels(static_cast<std::size_t>(size.x * size.y * layers));
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureImage(map.texture(), 0, GL_RED, GL_UNSIGNED_BYTE, static_cast<int>(texels.size()),
                    texels.data());
  int wrong = 0;
  for (int level = static_cast<int>(b.levels.y); level < shape.levels; ++level) {
    const double cell = std::ldexp(1.0, level);
    const double reach = level >= static_cast<int>(b.levels.z) ? 1e9 : 2 * b.scale.y;
    const int width = static_cast<int>(std::ceil(shape.width / cell));
    const int height = static_cast<int>(std::ceil(shape.height / cell));
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        // As in shaders/clipmap.glsl, in texels from the eye.
        const glm::dvec2 at = (glm::dvec2(x, y) + 0.5) * cell - glm::dvec2(b.size.z, b.size.w);
        const glm::dvec2 d = glm::abs(at - glm::dvec2(b.centre.x, b.centre.y)) / cell;
        if (std::max(d.x, d.y) > reach) continue;
        const auto& origin = b.origin[static_cast<std::size_t>(level)];
        const double u = origin.x + at.x * b.scale.z / cell;
        const double v = origin.y + at.y * b.scale.w / cell;
        const int i = static_cast<int>(std::floor((u - std::floor(u)) * size.x + 1e-3));
        const int j = static_cast<int>(std::floor((v - std::floor(v)) * size.y + 1e-3));
        const std::size_t k = static_cast<std::size_t>(((level - first) * size.y + j) * size.x + i);
        wrong += texels[k] == code(level, x, y, 0) ? 0 : 1;
      }
    }
  }
  return wrong;
}

TEST_F(ClipmapTest, HoldsWhatTheShaderMaySampleWhereverTheCameraGoes) {
  const ToyRaster source(700, 300, 1, kTile, code);
  Clipmap map(source, 4 * kTile * 4 * kTile * 8);
  ASSERT_NE(map.texture(), 0U);
  for (const glm::ivec2 post : {glm::ivec2(0, 0), glm::ivec2(350, 150), glm::ivec2(371, 133),
                                glm::ivec2(699, 299), glm::ivec2(-500, 900), glm::ivec2(40, 250)}) {
    SCOPED_TRACE(post.x);
    map.update(post, 0, 1 << 20);
    EXPECT_EQ(wrong_texels(map, source, post), 0);
  }
}

TEST_F(ClipmapTest, ALevelLeftBehindIsNotOffered) {
  const ToyRaster source(700, 300, 1, kTile, code);
  Clipmap map(source, 4 * kTile * 4 * kTile * 8);
  map.update({100, 100}, 0, 1 << 20);
  map.update({600, 200}, 100, 1 << 20);  // fills the coarsest level only
  EXPECT_EQ(map.block({600, 200}).levels.y, static_cast<float>(source.shape().levels - 1));
  EXPECT_EQ(wrong_texels(map, source, {600, 200}), 0);
}

TEST_F(ClipmapTest, TheCheckFindsOneWrongTexel) {
  const ToyRaster source(700, 300, 1, kTile, code);
  Clipmap map(source, 4 * kTile * 4 * kTile * 8);
  map.update({0, 0}, 0, 1 << 20);
  ASSERT_EQ(wrong_texels(map, source, {0, 0}), 0);
  const std::uint8_t fault = code(0, 0, 0, 0) ^ 1U;
  glTextureSubImage3D(map.texture(), 0, 0, 0, 0, 1, 1, 1, GL_RED, GL_UNSIGNED_BYTE, &fault);
  EXPECT_EQ(wrong_texels(map, source, {0, 0}), 1);
}

TEST_F(ClipmapTest, ReadsOnlyWhatCameIntoReach) {
  const ToyRaster source(4096, 4096, 1, kTile, code);
  Clipmap map(source, 16 * kTile * 16 * kTile * 9);
  const int all = map.update({2048, 2048}, 0, 1 << 20);
  EXPECT_EQ(map.update({2049, 2049}, 0, 1 << 20), 0);
  const int one_column = map.update({2048 + kTile, 2048}, 0, 1 << 20);
  EXPECT_GT(one_column, 0);
  EXPECT_LT(one_column, all / 4);
}

TEST_F(ClipmapTest, ABoundedUpdateCatchesUp) {
  const ToyRaster source(700, 300, 1, kTile, code);
  Clipmap map(source, 4 * kTile * 4 * kTile * 8);
  int frames = 0;
  do {
    EXPECT_LE(map.update({350, 150}, 0, 5), 5);
    EXPECT_EQ(wrong_texels(map, source, {350, 150}), 0);
    ++frames;
  } while (map.block({350, 150}).levels.y > map.block({350, 150}).levels.x && frames < 100);
  EXPECT_GT(frames, 3);
  EXPECT_LT(frames, 100);
}

TEST_F(ClipmapTest, KeepsItsBudget) {
  const ToyRaster source(5000, 3000, 2, kTile, code);
  for (const std::uint64_t budget : {100U, 5000U, 100000U, 10000000U}) {
    const Clipmap map(source, budget);
    EXPECT_LE(map.bytes(), budget);
    EXPECT_EQ(map.texture() != 0, map.bytes() > 0);
  }
}

}  // namespace
}  // namespace arete::render
