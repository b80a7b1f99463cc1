// A long flight over a store of several times the memory that it may take (CONVENTIONS I8).
#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>

#include "arete/lod/engine.h"

#include "lod/built_terrain.h"

namespace arete::lod {
namespace {

constexpr int kFrames = 2000;
constexpr int kPosts = 1025;
constexpr std::uint64_t kTileBytes = 500'000;  // the cache's

View view_at(double t) {
  const double side = 30.0 * (kPosts - 1);
  return make_view({.eye = {side * (0.5 + 0.45 * std::cos(13 * t)),
                            -side * (0.5 + 0.45 * std::sin(17 * t)), 1200 + 600 * std::sin(40 * t)},
                    .yaw = 20 * t,
                    .pitch = -0.35,
                    .near_m = 1},
                   320, 240);
}

class BudgetFlight : public testing::TestWithParam<std::string_view> {
 protected:
  static void SetUpTestSuite() {
    terrain_ =
        std::make_unique<BuiltTerrain>(rough_dem(kPosts, kPosts, 11, 0), Params{{"patch", "33"}});
  }
  static void TearDownTestSuite() { terrain_.reset(); }

  struct Flown {
    std::uint64_t late = 0, capped = 0;
  };

  // Flies that many of kFrames and checks each.
  Flown fly(int frames, bool prefetch, const Budget& budget) {
    store::OpenOptions open;
    open.cache_bytes = kTileBytes;
    open.prefetch = prefetch;
    const auto opened = terrain_->open(open);
    const auto engine =
        find_engine(GetParam()).open(*opened, params_for(GetParam(), {{"patch", "33"}}));
    require_room(engine->footprint(), budget, "t");
    RefineOptions options{.on_missing = OnMissing::Defer, .budget = budget};
    DrawList list;
    Flown flown;
    for (int k = 0; k < frames; ++k) {
      engine->refine(view_at(static_cast<double>(k) / kFrames), options, list);
      const RefineStats& s = list.stats;
      EXPECT_LE(s.resident_bytes, budget.vertex_bytes) << "frame " << k;
      EXPECT_LE(s.triangles, budget.triangles) << "frame " << k;
      EXPECT_LE(opened->cache_stats().resident_bytes, kTileBytes) << "frame " << k;
      flown.late += s.late_blocks;
      flown.capped += s.tolerance_px > options.tolerance_px ? 1 : 0;
      // As a display would: gives the prefetch thread its turn even where there is one core.
      if (k % 8 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_LE(opened->cache_stats().resident_bytes_max, kTileBytes);
    return flown;
  }

  static std::unique_ptr<BuiltTerrain> terrain_;
};

std::unique_ptr<BuiltTerrain> BudgetFlight::terrain_;

TEST_P(BudgetFlight, NeverHoldsMoreThanItMay) {
  const Budget budget{.triangles = 30'000, .vertex_bytes = 900'000};
  const auto heights = std::uint64_t{4} * kPosts * kPosts;
  EXPECT_GE(heights * 4 / 3, 4 * (kTileBytes + budget.vertex_bytes));
  const Flown with = fly(kFrames, true, budget);
  EXPECT_GT(with.capped, 0U);                                     // the control: the caps did bind
  if (params_for(GetParam(), {{"patch", "33"}}).empty()) return;  // it reads no tiles
  const Flown without = fly(kFrames / 4, false, budget);
  EXPECT_GT(4 * without.late, 2 * with.late);  // it flew a quarter as far
}

std::vector<std::string_view> engine_names() {
  std::vector<std::string_view> names;
  for (const EngineInfo& engine : engines()) names.push_back(engine.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(All, BudgetFlight, testing::ValuesIn(engine_names()),
                         [](const auto& tested) { return std::string(tested.param); });

}  // namespace
}  // namespace arete::lod
