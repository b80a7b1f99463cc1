#include <cmath>
#include <random>

#include "arete/core/normal_code.h"
#include "arete/store/terrain.h"

#include "store/store_fixture.h"

namespace arete::store {
namespace {

// The definition, in double: gradient in the world from central differences, one-sided at edges.
std::array<std::uint8_t, 2> reference_normal(const Heightfield& field, Post p, const Affine2& a) {
  const auto slope = [&](Post before, Post after, int steps) {
    return steps == 0 ? 0.0 : (static_cast<double>(field[after]) - field[before]) / steps;
  };
  const Post w{std::max(p.col - 1, 0), p.row};
  const Post e{std::min(p.col + 1, field.cols() - 1), p.row};
  const Post n{p.col, std::max(p.row - 1, 0)};
  const Post s{p.col, std::min(p.row + 1, field.rows() - 1)};
  const double zc = slope(w, e, e.col - w.col);
  const double zr = slope(n, s, s.row - n.row);
  const double det = a.determinant();
  const double zx = (a.m[4] * zc - a.m[3] * zr) / det;
  const double zy = (a.m[0] * zr - a.m[1] * zc) / det;
  return encode_normal(glm::normalize(glm::dvec3(-zx, -zy, 1)));
}

int worst_code_difference(const Heightfield& field, const RasterSource& normals, const Affine2& a) {
  int worst = 0;
  for (int y = 0; y * 256 < field.rows(); ++y)
    for (int x = 0; x * 256 < field.cols(); ++x) {
      const Texels t =
          normals.read({0, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)});
      for (int r = 0; r < std::min(256, field.rows() - y * 256); ++r)
        for (int c = 0; c < std::min(256, field.cols() - x * 256); ++c) {
          const auto want = reference_normal(field, {x * 256 + c, y * 256 + r}, a);
          for (std::size_t k = 0; k < 2; ++k)
            worst = std::max(
                worst, std::abs(t.bytes[static_cast<std::size_t>(r * 256 + c) * 2 + k] - want[k]));
        }
    }
  return worst;
}

TEST(Normals, AreThoseOfTheDefinitionOnAnyAffine) {
  for (const std::array<double, 6> m :
       {std::array<double, 6>{30, 0, 0, 0, -30, 0}, std::array<double, 6>{20, 7, 0, 5, -25, 0},
        std::array<double, 6>{0, 12, 0, 9, 0, 0}}) {
    Georef georef;
    georef.world_from_post.m = m;
    Heightfield field(391, 300, georef);
    const Heightfield hills = make_hills(391, 300, 12);
    for (int r = 0; r < 300; ++r)
      for (int c = 0; c < 391; ++c) field[{c, r}] = hills[{c, r}];
    field.set_lattice({true, 1, 0});
    TemporaryFolder folder;
    const auto terrain = Terrain::open(build_store(folder, field));
    const auto normals = terrain->raster("normals");
    EXPECT_LE(worst_code_difference(field, *normals, georef.world_from_post), 1);
    // Negative control: the axes the wrong way round.
    Affine2 turned = georef.world_from_post;
    std::swap(turned.m[0], turned.m[3]);
    std::swap(turned.m[1], turned.m[4]);
    EXPECT_GT(worst_code_difference(field, *normals, turned), 1);
  }
}

TEST(Normals, CoarserTexelsAreMeansOfFiner) {
  Heightfield field = make_hills(701, 530, 12);
  TemporaryFolder folder;
  const auto terrain = Terrain::open(build_store(folder, field));
  const auto normals = terrain->raster("normals");
  const RasterShape shape = normals->shape();
  ASSERT_EQ(shape.levels, 3);
  const auto texel = [&](std::uint32_t level, int col, int row) {
    const int width = ((701 - 1) >> level) + 1;
    const int height = ((530 - 1) >> level) + 1;
    col = std::min(col, width - 1);
    row = std::min(row, height - 1);
    const Texels t = normals->read(
        {level, static_cast<std::uint32_t>(col / 256), static_cast<std::uint32_t>(row / 256)});
    const auto i = static_cast<std::size_t>((row % 256) * 256 + col % 256) * 2;
    return std::array<std::uint8_t, 2>{t.bytes[i], t.bytes[i + 1]};
  };
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    const std::uint32_t level = 1 + random() % 2;
    const int col = static_cast<int>(random() % static_cast<unsigned>((700 >> level) + 1));
    const int row = static_cast<int>(random() % static_cast<unsigned>((529 >> level) + 1));
    glm::dvec3 sum(0);
    for (int q = 0; q < 4; ++q) {
      const auto code = texel(level - 1, 2 * col + q % 2, 2 * row + q / 2);
      sum += decode_normal(code[0], code[1]);
    }
    const auto want = encode_normal(glm::normalize(sum));
    const auto is = texel(level, col, row);
    EXPECT_LE(std::abs(is[0] - want[0]), 1) << level << ": " << col << ", " << row;
    EXPECT_LE(std::abs(is[1] - want[1]), 1) << level << ": " << col << ", " << row;
  }
}

TEST(Mask, IsTheValidityAndItsMeans) {
  Heightfield field = make_hills(530, 300, 2);
  punch_holes(field, 5, 31);
  TemporaryFolder folder;
  const auto terrain = Terrain::open(build_store(folder, field));
  const auto mask = terrain->raster("mask");
  ASSERT_TRUE(mask);
  int differences = 0;
  for (std::uint32_t y = 0; y < 2; ++y)
    for (std::uint32_t x = 0; x < 3; ++x) {
      const Texels t = mask->read({0, x, y});
      for (int r = 0; r < 256; ++r)
        for (int c = 0; c < 256; ++c) {
          const Post p{static_cast<int>(x) * 256 + c, static_cast<int>(y) * 256 + r};
          if (p.col >= 530 || p.row >= 300) continue;
          const bool is = t.bytes[static_cast<std::size_t>(r * 256 + c)] == 255;
          differences += is && !field.valid(p) ? 1 : 0;
        }
    }
  EXPECT_EQ(differences, 0);
  const Texels coarse = mask->read({2, 0, 0});
  double share = 0;
  for (int r = 0; r < 75; ++r)
    for (int c = 0; c < 132; ++c)
      share += coarse.bytes[static_cast<std::size_t>(r * 256 + c)] / 255.0 / (75 * 132);
  EXPECT_NEAR(share, 1 - terrain->manifest().nodata_share, 0.02);
}

TEST(Mask, IsAbsentWhenAllPostsAreValid) {
  Heightfield field = make_hills(140, 140, 2);
  TemporaryFolder folder;
  const auto terrain = Terrain::open(build_store(folder, field));
  EXPECT_EQ(terrain->raster("mask"), nullptr);
  EXPECT_FALSE(terrain->has_segment("mask"));
}

class StripedDrape : public RasterSource {
 public:
  explicit StripedDrape(int step = 7) : step_(step) {}
  RasterShape shape() const override { return {600, 300, 3, 256, 3, 1, 9}; }
  Texels read(TileId id) const override {
    Texels t{256, 3, std::vector<std::uint8_t>(3 * 256 * 256, 9)};
    if (id.x == 1) return t;
    for (std::size_t i = 0; i < t.bytes.size(); ++i)
      t.bytes[i] = static_cast<std::uint8_t>(i * static_cast<std::size_t>(step_) + id.key() % 251);
    return t;
  }

 private:
  int step_;
};

TEST(Drape, IsCopiedTileByTile) {
  Heightfield field = make_hills(300, 150, 2);
  const StripedDrape drape;
  TemporaryFolder folder;
  BuildOptions options;
  options.output = folder / "a.arete";
  options.drape = &drape;
  build(field, options, {});
  const auto terrain = Terrain::open(options.output);
  const auto stored = terrain->raster("drape");
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->shape().texels_per_post_log2, 1);
  EXPECT_EQ(stored->shape().fill, 9);
  for (const TileId id : {TileId{0, 0, 0}, TileId{0, 1, 0}, TileId{0, 2, 1}, TileId{2, 0, 0}})
    EXPECT_EQ(stored->read(id).bytes, drape.read(id).bytes);
}

TEST(Drape, AnotherPictureOfTheSameShapeTakesItsPlace) {
  Heightfield field = make_hills(300, 150, 2);
  TemporaryFolder folder;
  BuildOptions options;
  options.output = folder / "a.arete";
  for (const int step : {7, 11, 11}) {
    const StripedDrape drape(step);
    options.drape = &drape;
    build(field, options, {});
    EXPECT_EQ(Terrain::open(options.output)->raster("drape")->read({0, 2, 1}).bytes,
              drape.read({0, 2, 1}).bytes);
  }
}

}  // namespace
}  // namespace arete::store
