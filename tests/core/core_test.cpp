#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "arete/core/draw_list.h"
#include "arete/core/georef.h"
#include "arete/core/heightfield.h"
#include "arete/core/normal_code.h"
#include "arete/core/parallel.h"
#include "arete/core/tile_id.h"

namespace arete {
namespace {

TEST(TileId, KeyRoundTripsAndSortsByLevelRowColumn) {
  const TileId a{3, 70000, 12};
  EXPECT_EQ(TileId::from_key(a.key()), a);
  EXPECT_LT((TileId{0, 9, 9}).key(), (TileId{1, 0, 0}).key());
  EXPECT_LT((TileId{0, 9, 1}).key(), (TileId{0, 0, 2}).key());
}

TEST(TileId, ParentCoversItsChildren) {
  const TileId parent{4, 5, 6};
  for (int i = 0; i < 4; ++i) EXPECT_EQ(parent.child(i).parent(), parent);
}

TEST(Affine2, InverseSolvesApply) {
  const Affine2 a{{3, 0.5, 10, -0.25, -2, 7}};
  const glm::dvec2 p = a.inverse(a.apply(12, 34));
  EXPECT_NEAR(p.x, 12, 1e-12);
  EXPECT_NEAR(p.y, 34, 1e-12);
}

TEST(Heightfield, DrawableNeedsFourValidPosts) {
  Heightfield h(3, 3);
  EXPECT_TRUE(h.drawable({0, 0}));
  h[{2, 2}] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(h.drawable({0, 0}));
  EXPECT_FALSE(h.drawable({1, 1}));
}

TEST(NormalCode, KeepsTheAngleWithinOneDegreeBelowSixtyDegrees) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> slope(0, 0.7);
  for (int i = 0; i < 20000; ++i) {
    const glm::dvec3 n = glm::normalize(glm::dvec3(slope(random), slope(random), 1));
    if (n.z < 0.5) continue;
    const auto code = encode_normal(n);
    EXPECT_GT(glm::dot(n, decode_normal(code[0], code[1])), std::cos(0.0175)) << n.x << ' ' << n.y;
  }
}

TEST(MorphedZ, AppliesNamedSlotsOnly) {
  Vertex v;
  v.z = 10;
  v.dz = {1, 2, 4};
  v.slot = {0, 5, 255, 255};
  std::array<float, kFactorCount> f{};
  f[0] = 0.5F;
  f[5] = 0.25F;
  EXPECT_FLOAT_EQ(morphed_z(v, f), 11.0F);
}

TEST(ParallelFor, DoesEachItemOnce) {
  for (const int threads : {1, 2, 5}) {
    std::vector<std::atomic<int>> hits(1000);
    parallel_for(threads, 1000, [&](int i) { ++hits[static_cast<std::size_t>(i)]; });
    for (const auto& h : hits) EXPECT_EQ(h, 1);
  }
}

TEST(ParallelFor, HandsOnTheFirstException) {
  EXPECT_THROW(parallel_for(3, 100,
                            [](int i) {
                              if (i == 40) throw std::runtime_error("x");
                            }),
               std::runtime_error);
}

}  // namespace
}  // namespace arete
