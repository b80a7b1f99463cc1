#include "ground.h"

#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "arete/core/heightfield.h"
#include "arete/store/build.h"

namespace arete::app {
namespace {

namespace fs = std::filesystem;

/// A store of 300 x 200 posts whose heights are a plane, which every level keeps.
class GroundTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* const info = testing::UnitTest::GetInstance()->current_test_info();
    store_ =
        fs::path(testing::TempDir()) / (std::string("arete_ground_") + info->name() + ".arete");
    fs::remove_all(store_);
    Heightfield dem(300, 200);
    for (int row = 0; row < 200; ++row) {
      for (int col = 0; col < 300; ++col) {
        dem[{col, row}] = static_cast<float>(plane(col, row));
      }
    }
    store::BuildOptions options;
    options.output = store_;
    options.source_key = info->name();
    store::build(dem, options, {});
    terrain_ = store::Terrain::open(store_);
  }
  void TearDown() override {
    terrain_.reset();
    fs::remove_all(store_);
  }

  static double plane(double col, double row) { return 100 + 0.5 * col - 0.25 * row; }

  fs::path store_;
  std::unique_ptr<store::Terrain> terrain_;
};

TEST_F(GroundTest, HeightsBetweenPostsAreBilinear) {
  const scene::Ground ground = ground_of(*terrain_, store::Fetch::Wait);
  EXPECT_EQ(ground.cols, 300);
  EXPECT_EQ(ground.rows, 200);
  for (const auto& [col, row] : {std::pair{0.0, 0.0},
                                 {299.0, 199.0},
                                 {128.0, 128.0},
                                 {127.5, 128.5},
                                 {0.25, 198.75},
                                 {255.9, 0.1}}) {
    EXPECT_NEAR(ground.height(col, row), plane(col, row), 0.01) << col << ' ' << row;
  }
}

TEST_F(GroundTest, OutsideTheGridTheEdgeGoesOn) {
  const scene::Ground ground = ground_of(*terrain_, store::Fetch::Wait);
  EXPECT_NEAR(ground.height(-50, 10), plane(0, 10), 0.01);
  EXPECT_NEAR(ground.height(1000, 1000), plane(299, 199), 0.01);
}

TEST_F(GroundTest, WhatIsHeldAnswersWithoutAskingForMore) {
  const LeveledGround ground = ground_of(*terrain_, store::Fetch::Wait);
  for (int col = 0; col < 300; col += 7) {
    EXPECT_NEAR(ground.height_of_level(col, 100, 0, store::Fetch::Held), plane(col, 100), 1);
  }
  const store::CacheStats stats = terrain_->cache_stats();
  EXPECT_EQ(stats.misses, 1U);  // the one tile of the coarsest level
  EXPECT_EQ(stats.late, 0U);
}

TEST_F(GroundTest, BelowTheEyeIsExactWhereItIsNear) {
  const LeveledGround ground = ground_of(*terrain_, store::Fetch::Wait);
  const glm::dvec2 world = ground.world_from_post.apply(130.3, 40.6);
  for (const double above : {0.5, 100.0, 1e5}) {
    EXPECT_NEAR(height_below(ground, {world, plane(130.3, 40.6) + above}), plane(130.3, 40.6),
                0.01 + 0.001 * above);
  }
}

TEST_F(GroundTest, WithoutFineTilesACoarserOneAnswers) {
  const scene::Ground ground = ground_of(*terrain_, store::Fetch::Resident);
  EXPECT_NEAR(ground.height(100, 100), plane(100, 100), 1);
}

}  // namespace
}  // namespace arete::app
