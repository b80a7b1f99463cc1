#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/raster/dem.h"
#include "arete/raster/synthetic.h"

#include "raster/grid_files.h"

namespace arete::raster {
namespace {

using namespace testing;  // NOLINT: the room's own helpers
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::NanSensitiveFloatEq;
using ::testing::Not;
using ::testing::Pointwise;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// The plane 10 row + col of one global grid, cut out with `overlap` shared posts.
GridFile cut(int col, int row, int cols, int rows) {
  GridFile grid{.cols = cols, .rows = rows, .values = {}, .nodata = -1};
  grid.geotransform = {500000.0 + 30 * col, 30, 0, 4000000.0 - 30 * row, 0, -30};
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) grid.values.push_back(10 * (row + r) + col + c);
  }
  return grid;
}

class MosaicTest : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const GridFile& grid) {
    write_grid(dir_ / name, grid);
    return dir_ / name;
  }
  std::string refusal(const GridFile& a, const GridFile& b) {
    try {
      open_dem({write("r1.tif", a), write("r2.tif", b)});
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }
  TempDir dir_;
};

TEST_F(MosaicTest, TilesWithSharedBordersAreOneGrid) {
  // South-east first: the order of the files decides nothing where they agree.
  const auto mosaic =
      open_dem({write("se.tif", cut(3, 2, 4, 3)), write("nw.tif", cut(0, 0, 4, 3)),
                write("ne.tif", cut(3, 0, 4, 3)), write("sw.tif", cut(0, 2, 4, 3))});
  ASSERT_EQ(mosaic->cols(), 7);
  ASSERT_EQ(mosaic->rows(), 5);
  const std::vector<float> heights = read_all(*mosaic);
  for (int i = 0; i < 35; ++i) {
    EXPECT_EQ(heights[static_cast<std::size_t>(i)], 10 * (i / 7) + i % 7);
  }
  EXPECT_EQ(mosaic->georef().crs_from_post.apply(0, 0), glm::dvec2(500015, 3999985));
  EXPECT_TRUE(mosaic->lattice().integer);
  EXPECT_THAT(mosaic->georef().notes, Not(Contains(HasSubstr("differ"))));
}

// Any cut of a terrain, in any order, abutting or sharing posts, reads as the terrain.
TEST_F(MosaicTest, ATerrainCutIntoTilesIsTheTerrain) {
  constexpr int kSide = 65;
  const auto terrain = synthesize(SyntheticKind::Ridged, kSide, 3);
  std::vector<float> whole = read_all(*terrain);
  for (std::size_t i = 700; i < 800; ++i) whole[i] = kNone;
  std::mt19937 random(1);
  for (int trial = 0; trial < 20; ++trial) {
    SCOPED_TRACE(trial);
    const int shared = trial % 3;  // posts
    const auto at = [&](int low, int high) {
      return std::uniform_int_distribution(low, high)(random);
    };
    const std::array cols{0, at(5, 30), at(35, 60), kSide};
    const std::array rows{0, at(5, 60), kSide};
    std::vector<std::filesystem::path> files;
    for (std::size_t i = 0; i < 6; ++i) {
      const int col = cols[i % 3], row = rows[i / 3];
      const int col_end = std::min(kSide, cols[i % 3 + 1] + shared);
      const int row_end = std::min(kSide, rows[i / 3 + 1] + shared);
      GridFile grid = cut(col, row, col_end - col, row_end - row);
      grid.type = GDT_Float32;
      grid.values.clear();
      for (int r = row; r < row_end; ++r) {
        for (int c = col; c < col_end; ++c) {
          const float z = whole[static_cast<std::size_t>(r * kSide + c)];
          grid.values.push_back(std::isnan(z) ? -1 : static_cast<double>(z));
        }
      }
      files.push_back(write(std::to_string(trial) + "_" + std::to_string(i) + ".tif", grid));
    }
    std::shuffle(files.begin(), files.end(), random);
    const auto mosaic = open_dem(files);
    ASSERT_EQ(mosaic->cols(), kSide);
    EXPECT_THAT(read_all(*mosaic), Pointwise(NanSensitiveFloatEq(), whole));
    EXPECT_THAT(mosaic->georef().notes, Not(Contains(HasSubstr("differ"))));
  }
}

TEST_F(MosaicTest, HolesAreFilledAndTheFirstFileWins) {
  GridFile first = cut(0, 0, 3, 1), second = cut(2, 0, 3, 1);
  first.values = {1, 2, -1};
  second.values = {5, 6, 7};
  const auto filled = open_dem({write("a.tif", first), write("b.tif", second)});
  EXPECT_THAT(read_all(*filled), ElementsAre(1, 2, 5, 6, 7));
  first.values = {1, 2, 3};
  const auto contested = open_dem({write("c.tif", first), write("d.tif", second)});
  for (int pass = 0; pass < 2; ++pass) {
    EXPECT_THAT(read_all(*contested), ElementsAre(1, 2, 3, 6, 7));
  }
  EXPECT_THAT(contested->georef().notes,
              Contains(HasSubstr("1 posts that two files share differ, by up to 2 m")));
}

TEST_F(MosaicTest, GapsHaveNoData) {
  const auto mosaic = open_dem({write("a.tif", cut(0, 0, 1, 1)), write("b.tif", cut(2, 1, 1, 1))});
  EXPECT_THAT(read_all(*mosaic),
              ElementsAre(0, NanSensitiveFloatEq(kNone), NanSensitiveFloatEq(kNone),
                          NanSensitiveFloatEq(kNone), NanSensitiveFloatEq(kNone), 12));
}

TEST_F(MosaicTest, ManyFilesAreReadWithoutKeepingThemOpen) {
  std::vector<std::filesystem::path> files;
  for (int i = 0; i < 300; ++i) {
    files.push_back(write("t" + std::to_string(i) + ".tif", cut(0, 2 * i, 3, 3)));
  }
  const auto mosaic = open_dem(files);
  ASSERT_EQ(mosaic->rows(), 601);
  const std::vector<float> heights = read_all(*mosaic);
  for (std::size_t i = 0; i < heights.size(); ++i) {
    ASSERT_EQ(heights[i], static_cast<float>(10 * (i / 3) + i % 3));
  }
  const auto open_files = std::distance(std::filesystem::directory_iterator("/proc/self/fd"),
                                        std::filesystem::directory_iterator());
  EXPECT_LT(open_files, 100);
}

TEST_F(MosaicTest, AcrossTheDateLine) {
  GridFile west = cut(0, 0, 2, 1), east = cut(0, 0, 2, 1);
  west.crs = east.crs = "EPSG:4326";
  west.geotransform = {178, 1, 0, 10, 0, -1};
  east.geotransform = {-180, 1, 0, 10, 0, -1};
  const auto mosaic = open_dem({write("w.tif", west), write("e.tif", east)});
  EXPECT_EQ(mosaic->cols(), 4);
}

TEST_F(MosaicTest, OtherGridsAreRefused) {
  GridFile moved = cut(3, 0, 3, 3), coarser = cut(3, 0, 3, 3), other = cut(3, 0, 3, 3);
  moved.geotransform[0] += 0.5;
  EXPECT_THAT(refusal(cut(0, 0, 3, 3), moved), HasSubstr("alignment"));
  coarser.geotransform[1] = 30.001;
  EXPECT_THAT(refusal(cut(0, 0, 3, 3), coarser), HasSubstr("spacing"));
  other.crs = "EPSG:32612";
  EXPECT_THAT(refusal(cut(0, 0, 3, 3), other), HasSubstr("CRS"));
  GridFile nowhere = cut(3, 0, 3, 3);
  nowhere.geotransform.clear();
  EXPECT_THAT(refusal(cut(0, 0, 3, 3), nowhere), HasSubstr("where it lies"));
  moved = cut(3, 0, 3, 3);
  moved.geotransform[0] += 0.02;
  EXPECT_EQ(refusal(cut(0, 0, 3, 3), moved), "") << "less than a thousandth of a post";
}

TEST_F(MosaicTest, ReprojectionFollowsAPlane) {
  // Height = easting offset / 10 m in UTM: bilinear sampling of a plane is exact up to the map.
  GridFile grid{.cols = 80, .rows = 60, .type = GDT_Float32, .values = {}};
  for (int i = 0; i < 80 * 60; ++i) grid.values.push_back(3.0 * (i % 80));
  const auto file = write("plane.tif", grid);
  const auto dem = open_dem({file}, {.crs = "EPSG:4326"});
  const Georef georef = dem->georef();
  EXPECT_EQ(georef.crs_name, "WGS 84 (EPSG:4326)");
  OGRSpatialReference utm, geographic;
  utm.importFromEPSG(32611);
  geographic.importFromEPSG(4326);
  geographic.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<OGRCoordinateTransformation> back(
      OGRCreateCoordinateTransformation(&geographic, &utm));
  const std::vector<float> heights = read_all(*dem);
  int valid = 0;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    if (std::isnan(heights[i])) continue;
    const auto cols = static_cast<std::size_t>(dem->cols());
    glm::dvec2 p =
        georef.crs_from_post.apply(static_cast<double>(i % cols), static_cast<double>(i / cols));
    ASSERT_TRUE(back->Transform(1, &p.x, &p.y));
    EXPECT_NEAR(heights[i], (p.x - 500015) / 10, 0.1);  // 0.03 post
    ++valid;
  }
  EXPECT_GT(valid, 80 * 60 * 0.8);
  EXPECT_EQ(open_dem({file}, {.crs = "EPSG:32611"})->cols(), 80) << "same CRS: posts are kept";
}

TEST_F(MosaicTest, ReprojectionKeepsHolesAndNeedsACrs) {
  GridFile grid{.cols = 40, .rows = 40, .type = GDT_Float32, .values = {}, .nodata = -1};
  for (int i = 0; i < 1600; ++i) grid.values.push_back(i % 40 >= 20 ? -1 : 50);
  const auto dem = open_dem({write("half.tif", grid)}, {.crs = "EPSG:3857"});
  int valid = 0;
  for (const float z : read_all(*dem)) {
    EXPECT_TRUE(std::isnan(z) || z == 50);
    valid += std::isnan(z) ? 0 : 1;
  }
  EXPECT_NEAR(valid / (static_cast<double>(dem->cols()) * dem->rows()), 0.5, 0.06);
  grid.crs.clear();
  EXPECT_THROW(open_dem({write("bare.tif", grid)}, {.crs = "EPSG:3857"}), Error);
}

}  // namespace
}  // namespace arete::raster
