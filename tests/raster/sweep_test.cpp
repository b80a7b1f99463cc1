// Every file of the shared test data: read to the end, or one line of Error; never a word on
// stderr.
#include <chrono>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/raster/dem.h"

#include "raster/grid_files.h"

namespace arete::raster {
namespace {

using namespace testing;  // NOLINT: the room's own helpers
namespace fs = std::filesystem;

const fs::path kData = ARETE_SHARED_DATA;

struct Outcome {
  bool read = false;
  double low = 0, high = 0, nodata_share = 0;
  std::string error;
};

Outcome try_file(const fs::path& file, const DemOptions& options = {}) {
  Outcome outcome;
  try {
    double low = 1e300, high = -1e300, none = 0;
    const auto dem = open_dem({file}, options);
    const std::vector<float> heights = read_all(*dem);
    for (const float z : heights) {
      if (std::isnan(z)) {
        ++none;
        continue;
      }
      low = std::min(low, static_cast<double>(z));
      high = std::max(high, static_cast<double>(z));
    }
    outcome = {true, low, high, none / static_cast<double>(heights.size()), {}};
  } catch (const Error& error) {
    outcome.error = error.what();
  }
  return outcome;
}

TEST(Sweep, EveryFileReadsOrIsRefusedInOneLine) {
  if (!fs::exists(kData)) GTEST_SKIP() << "no shared test data beside the project";
  int read = 0, refused = 0;
  const CapturedStderr captured;
  for (const char* folder : {"small", "medium", "awkward", "awkward/gdal_autotest"}) {
    for (const auto& entry : fs::directory_iterator(kData / folder)) {
      if (!entry.is_regular_file()) continue;
      SCOPED_TRACE(entry.path().filename());
      const auto start = std::chrono::steady_clock::now();
      const Outcome outcome = try_file(entry.path());
      EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
      EXPECT_EQ(outcome.error.find('\n'), std::string::npos);
      EXPECT_EQ(outcome.error.find(kData.native()), std::string::npos) << outcome.error;
      if (!outcome.read) {
        EXPECT_NE(outcome.error.find(entry.path().filename().native() + ": "), std::string::npos)
            << outcome.error;
      }
      ++(outcome.read ? read : refused);
    }
  }
  EXPECT_EQ(captured.text(), "");
  RecordProperty("read", read);
  RecordProperty("refused", refused);
  EXPECT_GT(read, 100);
}

// From the list that came with the data.
TEST(Sweep, KnownFilesHaveTheirKnownRanges) {
  if (!fs::exists(kData)) GTEST_SKIP() << "no shared test data beside the project";
  struct Known {
    double low, high, nodata_percent;
  };
  const std::map<std::string, Known> known = {
      {"awkward/N51E002.hgt.zip", {-16, 42, 0}},
      {"awkward/aster_exploradores_nodata.tif", {317.71, 3959.9, 2.67}},
      {"awkward/bigtujunga_bigendian_stripped_bigtiff.tif", {315, 2295, 0}},
      {"awkward/bigtujunga_float64_lzw.tif", {315, 2295, 0}},
      {"awkward/dted_w124_n37.dt0", {0, 122, 0}},
      {"awkward/gironde_wave_bathymetry_218.tif", {-104.172, -4.15132, 76.01}},
      {"awkward/gz_dem_nodata.dem", {682, 2932, 2.27}},
      {"awkward/gz_dem_nodata_nan.nc", {682, 2932, 2.59}},
      {"awkward/rainier_cog_deflate_ovr.tif", {263, 4371, 0.63}},
      {"awkward/rainier_1025x1025.r16", {0, 4371, 0}},
      {"awkward/sthelens_327x468.asc", {682, 2543, 2.71}},
      {"awkward/sthelens_f32.flt", {682, 2543, 2.71}},
      {"awkward/sthelens_i16.bil", {682, 2543, 2.71}},
      {"awkward/sthelens_usfeet_f32.tif", {682, 2543, 2.71}},
      {"medium/SainteHelens.dem", {682, 2543, 2.71}},
      {"medium/mt_everest_srtm3_1201.tif", {192, 8642, 9.08}},
      {"medium/mars_mola_topography_1440x720.tif", {-8068, 21134, 0}},
      {"small/luxembourg_terra_elev_95x90.tif", {141, 547, 46.11}},
  };
  for (const auto& [name, expected] : known) {
    SCOPED_TRACE(name);
    const Outcome outcome = try_file(kData / name);
    ASSERT_TRUE(outcome.read) << outcome.error;
    EXPECT_NEAR(outcome.low, expected.low, 0.01);
    EXPECT_NEAR(outcome.high, expected.high, 0.05);
    EXPECT_NEAR(100 * outcome.nodata_share, expected.nodata_percent, 0.006);
  }
}

TEST(Sweep, SouthUpEqualsNorthUp) {
  if (!fs::exists(kData)) GTEST_SKIP() << "no shared test data beside the project";
  const auto north = open_dem({kData / "medium/bigtujunga_srtm_30m_1197x643.tif"});
  for (const char* twin :
       {"southup", "pixelispoint", "bigendian_stripped_bigtiff", "float64_lzw"}) {
    const auto other = open_dem({kData / ("awkward/bigtujunga_" + std::string(twin) + ".tif")});
    EXPECT_EQ(read_all(*other), read_all(*north)) << twin;
    const Affine2 a = north->georef().crs_from_post, b = other->georef().crs_from_post;
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(a.m[k], b.m[k], 1e-6) << twin;
  }
}

// The default sample of the documentation, as Debian ships it: feet, no CRS, float axes.
TEST(Sweep, TrinidadInFeetIsTheMetresOfItsTwin) {
  const fs::path feet = "/usr/share/ncarg/data/cdf/trinidad.nc";
  if (!fs::exists(kData) || !fs::exists(feet)) GTEST_SKIP() << "no libncarg-data here";
  const auto sample = open_dem({feet}, {.unit = Unit::Foot});
  const auto metres = open_dem({kData / "medium/trinidad_co_usgs_2401x1201_m.tif"});
  const Georef georef = sample->georef();
  EXPECT_NEAR(georef.crs_from_post.apply(0, 0).x, -106, 1e-9);
  EXPECT_NEAR(georef.crs_from_post.apply(0, 0).y, 38, 1e-9);
  EXPECT_NEAR(georef.crs_from_post.apply(2400, 1200).x, -104, 1e-9);
  EXPECT_NEAR(georef.crs_from_post.apply(2400, 1200).y, 37, 1e-9);
  const std::vector<float> a = read_all(*sample), b = read_all(*metres);
  ASSERT_EQ(a.size(), b.size());
  // The sample was made with 3.28 feet a metre.
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_NEAR(a[i] / (3.28 * 0.3048), b[i], 0.01) << i;
  }
}

}  // namespace
}  // namespace arete::raster
