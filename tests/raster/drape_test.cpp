#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/raster/dem.h"

#include "raster/grid_files.h"

namespace arete::raster {
namespace {

using namespace testing;  // NOLINT: the room's own helpers

constexpr std::size_t kTile = 256;

int channel(const Texels& tile, std::size_t x, std::size_t y, std::size_t k) {
  return tile.bytes[(y * kTile + x) * 3 + k];
}

// Red = column, green = row, blue = 9.
GridFile picture(int cols, int rows) {
  GridFile grid{.cols = cols,
                .rows = rows,
                .bands = 3,
                .type = GDT_Byte,
                .values = {},
                .options = {"PHOTOMETRIC=RGB"}};
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < cols * rows; ++i) {
      grid.values.push_back(k == 0 ? i % cols : k == 1 ? i / cols : 9);
    }
  }
  return grid;
}

TEST(Drape, OnTheSameGridIsACopy) {
  const TempDir dir;
  write_grid(dir / "p.tif", picture(100, 80));
  const auto dem = open_dem({dir / "p.tif"}, {.band = 1});
  const auto drape = open_drape(dir / "p.tif", 100, 80, dem->georef());
  const RasterShape shape = drape->shape();
  EXPECT_EQ(shape.width, 100);
  EXPECT_EQ(shape.height, 80);
  EXPECT_EQ(shape.texels_per_post_log2, 0);
  EXPECT_EQ(shape.channels, 3);
  EXPECT_EQ(shape.levels, 1);
  const Texels tile = drape->read({0, 0, 0});
  for (std::size_t y = 0; y < 80; ++y) {
    for (std::size_t x = 0; x < 100; ++x) {
      ASSERT_EQ(channel(tile, x, y, 0), static_cast<int>(x));
      ASSERT_EQ(channel(tile, x, y, 1), static_cast<int>(y));
      ASSERT_EQ(channel(tile, x, y, 2), 9);
    }
  }
  EXPECT_EQ(channel(tile, 100, 0, 0), shape.fill);
  EXPECT_EQ(channel(drape->read({0, 5, 5}), 0, 0, 0), shape.fill) << "beyond the grid";
  EXPECT_EQ(channel(drape->read({9, 0, 0}), 0, 0, 0), shape.fill) << "beyond the pyramid";
}

TEST(Drape, AnUnplacedPictureIsStretchedAndNotCoarsened) {
  const TempDir dir;
  GridFile grid = picture(200, 100);
  grid.crs.clear();
  grid.geotransform.clear();
  write_grid(dir / "p.tif", grid);
  const auto drape = open_drape(dir / "p.tif", 51, 26, {});
  EXPECT_EQ(drape->shape().texels_per_post_log2, 2);
  EXPECT_EQ(drape->shape().width, 201);
  const Texels tile = drape->read({0, 0, 0});
  // Half a post of the picture lies outside of the outermost posts.
  for (std::size_t x = 0; x < 201; ++x) {
    const double expected = (static_cast<double>(x) / 4 + 0.5) * 200 / 51 - 0.5;
    EXPECT_NEAR(channel(tile, x, 50, 0), std::clamp(expected, 0.0, 199.0), 0.75);
  }
}

TEST(Drape, CoarserLevelsAreMeans) {
  const TempDir dir;
  GridFile grid = picture(700, 600);
  for (double& v : grid.values) v = std::fmod(v * 7, 256);
  write_grid(dir / "p.tif", grid);
  const auto dem = open_dem({dir / "p.tif"}, {.band = 1});
  const auto drape = open_drape(dir / "p.tif", 700, 600, dem->georef());
  ASSERT_EQ(drape->shape().levels, 3);
  for (std::uint32_t level = 1; level < 3; ++level) {
    const Texels coarse = drape->read({level, 0, 0});
    const Texels fine = drape->read({level - 1, 0, 0});
    for (std::size_t y = 0; y < 128; ++y) {
      for (std::size_t x = 0; x < 128; ++x) {
        const int sum = channel(fine, 2 * x, 2 * y, 0) + channel(fine, 2 * x + 1, 2 * y, 0) +
                        channel(fine, 2 * x, 2 * y + 1, 0) + channel(fine, 2 * x + 1, 2 * y + 1, 0);
        ASSERT_EQ(channel(coarse, x, y, 0), (sum + 2) / 4);
      }
    }
  }
}

TEST(Drape, IsWarpedBetweenTwoCrs) {
  const TempDir dir;
  write_grid(dir / "p.tif", picture(120, 120));
  const auto dem = open_dem({dir / "p.tif"}, {.band = 1, .crs = "EPSG:4326"});
  const auto drape = open_drape(dir / "p.tif", dem->cols(), dem->rows(), dem->georef());
  const Texels tile = drape->read({0, 0, 0});
  const auto log2 = static_cast<unsigned>(drape->shape().texels_per_post_log2);
  std::vector<float> row(static_cast<std::size_t>(dem->cols()));
  for (int r = 10; r < dem->rows() - 10; r += 9) {
    dem->read_row(r, row);  // band 1 is the column, as red is
    for (std::size_t c = 10; c + 10 < row.size(); c += 7) {
      if (std::isnan(row[c]) || (c << log2) >= kTile || (r << log2) >= 256) continue;
      EXPECT_NEAR(channel(tile, c << log2, static_cast<std::size_t>(r) << log2, 0), row[c], 0.8);
    }
  }
}

TEST(Drape, GreyAndSixteenBits) {
  const TempDir dir;
  write_grid(dir / "g.tif", {.cols = 2, .rows = 1, .type = GDT_UInt16, .values = {0x1234, 0xFF00}});
  const auto drape = open_drape(dir / "g.tif", 2, 1, {});
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(channel(drape->read({0, 0, 0}), 0, 0, k), 0x12);
    EXPECT_EQ(channel(drape->read({0, 0, 0}), 1, 0, k), 0xFF);
  }
  write_grid(dir / "f.tif", {.type = GDT_Float32});
  EXPECT_THROW(open_drape(dir / "f.tif", 2, 1, {}), Error);
}

}  // namespace
}  // namespace arete::raster
