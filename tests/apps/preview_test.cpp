#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/core/heightfield.h"
#include "arete/raster/dem.h"

#include "background_open.h"
#include "place.h"
#include "thinned_rows.h"

namespace arete::app {
namespace {

namespace fs = std::filesystem;

Heightfield waves(int cols, int rows) {
  Heightfield dem(cols, rows);
  for (int row = 0; row < rows; ++row) {
    for (int col = 0; col < cols; ++col) {
      dem[{col, row}] = static_cast<float>(50 * std::sin(col / 40.0) + row % 97);
    }
  }
  return dem;
}

TEST(ThinnedRows, IsEveryKthPostAtTheSamePlace) {
  Heightfield full = waves(103, 58);
  full[{14, 21}] = std::numeric_limits<float>::quiet_NaN();
  const Georef placed = full.georef();
  for (const int step : {1, 2, 7, 57, 200}) {
    SCOPED_TRACE(step);
    ThinnedRows thin(full, step);
    EXPECT_EQ(thin.cols(), (full.cols() - 1) / step + 1);
    EXPECT_EQ(thin.rows(), (full.rows() - 1) / step + 1);
    const Georef georef = thin.georef();
    std::vector<float> row(static_cast<std::size_t>(thin.cols()));
    for (int r = 0; r < thin.rows(); ++r) {
      thin.read_row(r, row);
      for (int c = 0; c < thin.cols(); ++c) {
        const float z = row[static_cast<std::size_t>(c)];
        const float same = full[{c * step, r * step}];
        EXPECT_TRUE(z == same || (std::isnan(z) && std::isnan(same)));
        EXPECT_EQ(georef.world_from_post.apply(c, r),
                  placed.world_from_post.apply(c * step, r * step));
        EXPECT_EQ(georef.crs_from_post.apply(c, r), placed.crs_from_post.apply(c * step, r * step));
      }
    }
  }
}

class BackgroundOpenTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* const info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("arete_open_") + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "tmp");
    setenv("XDG_CACHE_HOME", (folder_ / "cache").c_str(), 1);
    setenv("TMPDIR", (folder_ / "tmp").c_str(), 1);
    flags_.talk = Talk::Quiet;
    flags_.terrain = folder_ / "dem.tif";
  }
  void TearDown() override {
    unsetenv("XDG_CACHE_HOME");
    unsetenv("TMPDIR");
    fs::remove_all(folder_);
  }
  void write_dem(int cols, int rows) {
    Heightfield dem = waves(cols, rows);
    raster::write_geotiff(dem, flags_.terrain);
  }
  /// All that comes until it has finished.
  static std::vector<OpenedTerrain> take_all(BackgroundOpen& opening) {
    std::vector<OpenedTerrain> all;
    for (bool last = false; !last;) {
      last = opening.finished();
      if (auto opened = opening.take()) {
        all.push_back(std::move(*opened));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return all;
  }

  fs::path folder_;
  TerrainFlags flags_;
};

TEST_F(BackgroundOpenTest, ALargeDemGivesAPreviewThenTheWholeInTheSameWorld) {
  write_dem(1500, 1100);
  BackgroundOpen opening(flags_, "geomipmap");
  const auto all = take_all(opening);
  ASSERT_FALSE(opening.failure());
  ASSERT_EQ(all.size(), 2U);
  EXPECT_TRUE(all[0].preview);
  EXPECT_FALSE(all[1].preview);
  const store::Manifest& preview = all[0].terrain->manifest();
  const store::Manifest& whole = all[1].terrain->manifest();
  EXPECT_EQ(preview.cols, 750);
  EXPECT_EQ(whole.cols, 1500);
  EXPECT_EQ(preview.georef.world_from_post.apply(100, 200),
            whole.georef.world_from_post.apply(200, 400));
  EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));
  EXPECT_NO_THROW(all[0].terrain->check_all());  // its files are open, though they have no names
}

TEST_F(BackgroundOpenTest, ASmallDemAndACachedStoreNeedNoPreview) {
  write_dem(300, 200);
  for (int times = 0; times < 2; ++times) {
    BackgroundOpen opening(flags_, "geomipmap");
    const auto all = take_all(opening);
    ASSERT_EQ(all.size(), 1U);
    EXPECT_FALSE(all[0].preview);
    EXPECT_EQ(all[0].source, flags_.terrain);
  }
}

TEST_F(BackgroundOpenTest, AFailureIsTold) {
  std::ofstream(flags_.terrain) << "no DEM";
  BackgroundOpen opening(flags_, "geomipmap");
  EXPECT_TRUE(take_all(opening).empty());
  ASSERT_TRUE(opening.failure());
  EXPECT_THROW(std::rethrow_exception(opening.failure()), Error);
}

TEST_F(BackgroundOpenTest, CancellingLeavesNoPreviewAndNoHalfStore) {
  write_dem(3000, 2000);
  for (const int ms : {0, 20, 60, 120}) {
    {
      BackgroundOpen opening(flags_, "geomipmap");
      std::this_thread::sleep_for(std::chrono::milliseconds(ms));
    }
    EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));
  }
  BackgroundOpen again(flags_, "geomipmap");
  const auto all = take_all(again);
  ASSERT_FALSE(again.failure());
  EXPECT_NO_THROW(all.back().terrain->check_all());
}

TEST(Place, SaysLatitudeAndLongitudeWhereTheyAreKnown) {
  Georef georef;
  EXPECT_EQ(Place(georef).text({3, -4}), "x 3.00  y -4.00");
  EXPECT_EQ(lat_lon_text({-104.66645, 37.26818}), "37.26818\u00b0 N  104.66645\u00b0 W");
  EXPECT_EQ(lat_lon_text({255.33355, -37.26818}), "37.26818\u00b0 S  104.66645\u00b0 W");
  georef.crs = "EPSG:4326";
  georef.crs_from_post = {{0.01, 0, 10, 0, -0.01, 50}};
  EXPECT_EQ(Place(georef).text({100, -100}), "49.00000\u00b0 N  11.00000\u00b0 E");
  georef.crs = "EPSG:32632";  // 500 km east of zone 32's origin lies 9 degrees east
  georef.crs_from_post = {{30, 0, 500000, 0, -30, 0}};
  EXPECT_EQ(Place(georef).text({0, 0}), "x 500000.00  y 0.00\n0.00000\u00b0 N  9.00000\u00b0 E");
}

}  // namespace
}  // namespace arete::app
