#include "arete/lod/error_tables.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "lod/patch_fixture.h"

namespace arete::lod {
namespace {

double worst(const RandomPatch& patch, const Levels& levels) {
  const auto z = drawn_heights(patch, levels);
  double result = 0;
  for (int row = 0; row < patch.posts(); ++row) {
    for (int col = 0; col < patch.posts(); ++col) {
      const double d =
          z[static_cast<std::size_t>(row * patch.posts() + col)] - patch.height(col, row);
      EXPECT_FALSE(std::isnan(d));
      result = std::max(result, std::abs(d));
    }
  }
  return result;
}

double mix(const std::vector<double>& knots, float level) {
  const auto l = std::min(static_cast<std::size_t>(level), knots.size() - 1);
  if (l + 1 == knots.size()) return knots[l];
  const double t = level - static_cast<float>(l);
  return (1 - t) * knots[l] + t * knots[l + 1];
}

double bound(const PatchErrors& e, const Levels& levels) {
  double result = mix(e.uniform, levels.own);
  for (std::size_t q = 0; q < kSides; ++q) {
    if (levels.side[q] > levels.own) result = std::max(result, mix(e.side[q], levels.side[q]));
  }
  return result;
}

TEST(ErrorTables, UniformIsExactAtEveryLevel) {
  for (const bool odd : {false, true}) {
    const RandomPatch patch(4, odd, 11, 20);
    const PatchErrors e = patch.errors();
    for (int l = 0; l <= 4; ++l) {
      const auto x = static_cast<float>(l);
      EXPECT_NEAR(worst(patch, {x, {x, x, x, x}}), e.uniform[static_cast<std::size_t>(l)], 1e-3);
    }
  }
}

TEST(ErrorTables, BoundEveryMixOfLevels) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<float> unit(0, 1);
  double largest_share = 0;
  for (int k = 0; k < 600; ++k) {
    const int w = 2 + k % 4;
    const RandomPatch patch(w, k % 2 == 0, static_cast<std::uint64_t>(k / 20), 1 + k % 7 * 5);
    const PatchErrors e = patch.errors();
    Levels levels;
    levels.own = unit(random) * static_cast<float>(w);
    if (k % 5 == 0) levels.own = std::floor(levels.own);
    for (float& side : levels.side) {
      side = std::min(static_cast<float>(w),
                      levels.own + (k % 3 == 0 ? std::round(unit(random)) : unit(random)));
    }
    const double measured = worst(patch, levels);
    ASSERT_LE(measured, bound(e, levels) * (1 + 1e-6) + 1e-3) << "case " << k;
    if (bound(e, levels) > 1) largest_share = std::max(largest_share, measured / bound(e, levels));
  }
  // The control: tables 10 % too small would have been caught.
  EXPECT_GT(largest_share, 0.9);
}

TEST(ErrorTables, OnlyCountedPostsCount) {
  const RandomPatch patch(3, false, 3, 30);
  std::vector<std::int32_t> counts;
  for (int j = 0; j < 9; ++j) {
    for (int i = 0; i < 9; ++i) counts.push_back(static_cast<std::int32_t>(patch.height(i, j)));
  }
  std::vector<std::uint8_t> counted(counts.size(), 1);
  counts[4 * 9 + 5] += 100000;  // a spike ...
  const double with = patch_errors({counts.data(), 9, 3, false, counted.data()}).uniform[3];
  counted[4 * 9 + 5] = 0;  // ... where there is no data
  const double without = patch_errors({counts.data(), 9, 3, false, counted.data()}).uniform[3];
  EXPECT_GT(with, 90000);
  EXPECT_LT(without, 10000);
}

TEST(ErrorTables, FlatAndTiltedPatchesAreFree) {
  std::vector<std::int32_t> counts;
  for (int j = 0; j < 17; ++j) {
    for (int i = 0; i < 17; ++i) counts.push_back(1000 - 7 * i + 3 * j);
  }
  const PatchErrors e = patch_errors({counts.data(), 17, 4, true, nullptr});
  for (const double v : e.uniform) EXPECT_EQ(v, 0);
  for (const auto& side : e.side) {
    for (const double v : side) EXPECT_EQ(v, 0);
  }
}

}  // namespace
}  // namespace arete::lod
