#include "arete/raster/synthetic.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/core/heightfield.h"

#include "raster/grid_files.h"

namespace arete::raster {
namespace {

using namespace testing;  // NOLINT: the room's own helpers

constexpr SyntheticKind kKinds[] = {SyntheticKind::Fbm, SyntheticKind::Ridged,
                                    SyntheticKind::Terraces, SyntheticKind::Flat,
                                    SyntheticKind::Slope};

TEST(Synthetic, AnyRowAloneIsTheSame) {
  for (const SyntheticKind kind : kKinds) {
    const auto source = synthesize(kind, 65, 4);
    const std::vector<float> all = read_all(*source);
    const auto other = synthesize(kind, 65, 4);
    std::vector<float> row(65);
    for (const int r : {64, 3, 40, 3}) {
      other->read_row(r, row);
      EXPECT_TRUE(std::equal(row.begin(), row.end(), all.begin() + r * 65));
    }
  }
}

TEST(Synthetic, SeedsDifferAndRangesAreNatural) {
  for (const SyntheticKind kind :
       {SyntheticKind::Fbm, SyntheticKind::Ridged, SyntheticKind::Terraces}) {
    const std::vector<float> a = read_all(*synthesize(kind, 257, 1));
    const std::vector<float> b = read_all(*synthesize(kind, 257, 2));
    EXPECT_NE(a, b);
    const auto [low, high] = std::minmax_element(a.begin(), a.end());
    const double relief = 0.1 * 256 * 30;
    EXPECT_GT(*high - *low, 0.3 * relief);
    EXPECT_LT(*high - *low, 1.6 * relief);
  }
}

TEST(Synthetic, FlatIsFlatAndSlopeIsAPlane) {
  for (const float z : read_all(*synthesize(SyntheticKind::Flat, 9, 1))) EXPECT_EQ(z, 0);
  Heightfield slope(*synthesize(SyntheticKind::Slope, 17, 1));
  for (int r = 1; r < 16; ++r) {
    for (int c = 1; c < 16; ++c) {
      const float middle = (slope[{c - 1, r - 1}] + slope[{c + 1, r + 1}]) / 2;
      EXPECT_NEAR((slope[Post{c, r}]), middle, 1e-4);
    }
  }
}

// No steps at the borders of noise cells: slopes stay bounded everywhere.
TEST(Synthetic, NeighboursAreNear) {
  for (const SyntheticKind kind : {SyntheticKind::Fbm, SyntheticKind::Ridged}) {
    const Heightfield field(*synthesize(kind, 513, 9));
    for (int r = 0; r < 512; ++r) {
      for (int c = 0; c < 512; ++c) {
        ASSERT_LT((std::abs(field[Post{c, r}] - field[Post{c + 1, r}])), 90) << c << ' ' << r;
        ASSERT_LT((std::abs(field[Post{c, r}] - field[Post{c, r + 1}])), 90) << c << ' ' << r;
      }
    }
  }
}

TEST(Synthetic, EverySizeFromOne) {
  for (const SyntheticKind kind : kKinds) {
    for (const int size : {1, 2, 3, 5, 100}) {
      for (const float z : read_all(*synthesize(kind, size, 7))) EXPECT_TRUE(std::isfinite(z));
    }
  }
  EXPECT_THROW(synthesize(SyntheticKind::Fbm, 0, 1), Error);
}

}  // namespace
}  // namespace arete::raster
