// The out-of-core part of `bench --paper smart`: its budget, its progress, and where it is not
// flown.
#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "arete/proof/papers/smart_out_of_core.h"

#include "lod/built_terrain.h"
#include "lod/recorded_terrain.h"

namespace arete::proof::smart {
namespace {

using lod::bintree::RecordedTerrain;

/// Along a diagonal of the terrain.
LateSetting flight(glm::dvec2 start, int frames, double step_m) {
  LateSetting out{"test", 4, {}};
  for (int i = 0; i < frames; ++i)
    out.flight.push_back(make_view({.eye = {start.x + step_m * i, start.y + step_m * i, 900},
                                    .yaw = 0.4,
                                    .pitch = -0.3,
                                    .near_m = 1},
                                   160, 120));
  return out;
}
constexpr glm::dvec2 kStart{2000, -16000};

double measured(const std::vector<PaperRow>& rows, const std::string& quantity) {
  const auto row = std::ranges::find(rows, quantity, &PaperRow::quantity);
  EXPECT_NE(row, rows.end()) << quantity;
  return row == rows.end() ? -1 : row->measured.value_or(-1);
}

class OutOfCoreTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { terrain_ = new RecordedTerrain(lod::rough_dem(900, 800, 9, 0)); }
  static void TearDownTestSuite() { delete terrain_; }

  static const RecordedTerrain* terrain_;
};

const RecordedTerrain* OutOfCoreTest::terrain_ = nullptr;

TEST_F(OutOfCoreTest, TheBudgetBindsAndHoldsTwoFrames) {
  constexpr int kFrames = 30;
  std::vector<double> told;
  const auto rows = out_of_core(terrain_->terrain(), flight(kStart, kFrames, 300),
                                [&](std::string_view, double done) { told.push_back(done); });
  const double stored = measured(rows, "page_bytes_stored"),
               budget = measured(rows, "page_budget_bytes");
  // The block of maxima is no page.
  EXPECT_EQ(stored, 4096.0 * static_cast<double>(terrain_->terrain().keys("bintree").size() - 1));
  EXPECT_LE(budget, stored / 8);
  EXPECT_LT(budget, measured(rows, "page_bytes_of_flight"));
  EXPECT_GE(budget, 2 * measured(rows, "page_bytes_of_frame"));
  EXPECT_EQ(measured(rows, "page_cache_bytes_max"), budget);
  EXPECT_EQ(measured(rows, "cracks"), 0);

  EXPECT_GE(told.size(), 13U * kFrames);  // 1 + 3 x 2 flights; 3 more that are kept and checked
  EXPECT_TRUE(std::ranges::is_sorted(told));
  EXPECT_EQ(told.front(), 0);
  EXPECT_GT(told.back(), 0.9);
  EXPECT_LE(told.back(), 1);
}

TEST_F(OutOfCoreTest, StopsAtAnyFrame) {
  struct Stop {};
  for (const int at : {1, 20, 100}) {
    int told = 0;
    EXPECT_THROW(out_of_core(terrain_->terrain(), flight(kStart, 30, 300),
                             [&](std::string_view, double) {
                               if (++told == at) throw Stop();
                             }),
                 Stop);
    EXPECT_EQ(told, at);
  }
}

TEST_F(OutOfCoreTest, SaysWhyNothingIsFlown) {
  const auto only_note = [](const store::Terrain& terrain, const LateSetting& setting) {
    const auto rows = out_of_core(terrain, setting, {});
    EXPECT_EQ(rows.size(), 1U);
    EXPECT_FALSE(rows.front().measured);
    return rows.front().note;
  };
  EXPECT_NE(only_note(terrain_->terrain(), flight(kStart, 5, 0)).find("fly more frames"),
            std::string::npos);
  const RecordedTerrain small(lod::rough_dem(129, 129, 9, 0));
  EXPECT_NE(only_note(small.terrain(), flight({2000, -2000}, 5, 0)).find("take a larger terrain"),
            std::string::npos);
}

}  // namespace
}  // namespace arete::proof::smart
