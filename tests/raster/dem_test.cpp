#include "arete/raster/dem.h"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>

#include <cpl_conv.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "arete/core/error.h"

#include "raster/grid_files.h"

namespace arete::raster {
namespace {

using namespace testing;  // NOLINT: the room's own helpers
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::FloatEq;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::NanSensitiveFloatEq;
using ::testing::Not;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

class DemTest : public ::testing::Test {
 protected:
  std::unique_ptr<HeightSource> open(const GridFile& grid, const DemOptions& options = {}) {
    const auto file = dir_ / ("dem" + std::to_string(next_++) + ".tif");
    write_grid(file, grid);
    return open_dem({file}, options);
  }

  ErrorCode code_of(const std::vector<std::filesystem::path>& files,
                    const DemOptions& options = {}) {
    try {
      read_all(*open_dem(files, options));
    } catch (const Error& error) {
      text_ = error.what();
      EXPECT_EQ(text_.find('\n'), std::string::npos) << text_;
      return error.code();
    }
    ADD_FAILURE() << "opened and read " << files.front();
    return ErrorCode::Usage;
  }

  TempDir dir_;
  int next_ = 0;
  std::string text_;
};

TEST_F(DemTest, EveryRealSampleTypeReadsAsItIs) {
  for (const GDALDataType type : {GDT_Byte, GDT_Int16, GDT_UInt16, GDT_Int32, GDT_UInt32, GDT_Int64,
                                  GDT_UInt64, GDT_Float32, GDT_Float64}) {
    SCOPED_TRACE(GDALGetDataTypeName(type));
    const auto dem = open({.cols = 2, .rows = 2, .type = type, .values = {0, 7, 100, 255}});
    EXPECT_THAT(read_all(*dem), ElementsAre(0, 7, 100, 255));
    EXPECT_EQ(dem->lattice().integer, GDALDataTypeIsInteger(type) != 0);
  }
}

TEST_F(DemTest, RowsComeInAnyOrder) {
  std::vector<double> values(1000);
  std::mt19937 random(7);
  for (double& v : values) v = static_cast<double>(random() % 4000);
  const auto dem = open({.cols = 10,
                         .rows = 100,
                         .values = values,
                         .options = {"TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=16"}});
  std::vector<float> row(10);
  for (int k = 0; k < 200; ++k) {
    const auto r = static_cast<int>(random() % 100);
    dem->read_row(r, row);
    for (std::size_t c = 0; c < 10; ++c) {
      EXPECT_EQ(row[c], values[static_cast<std::size_t>(r) * 10 + c]);
    }
  }
}

TEST_F(DemTest, ComplexSamplesAreRefused) {
  write_grid(dir_ / "c.tif", {.type = GDT_CFloat32});
  EXPECT_EQ(code_of({dir_ / "c.tif"}), ErrorCode::Unsupported);
  EXPECT_THAT(text_, HasSubstr("c.tif: "));
}

TEST_F(DemTest, DeclaredNodataIsComparedInTheSourceTypeBeforeScaling) {
  const auto dem = open({.cols = 3,
                         .rows = 1,
                         .values = {-32768, 10, -3276},
                         .nodata = -32768,
                         .scale = 0.5,
                         .offset = 100});
  EXPECT_THAT(read_all(*dem), ElementsAre(NanSensitiveFloatEq(kNone), 105, -1538));
  EXPECT_EQ(dem->lattice().step_m, 0.5);
  EXPECT_EQ(dem->lattice().offset_m, 100);
}

TEST_F(DemTest, FloatNodataMatchesWithinOneUlpAndNoFurther) {
  const float nodata = -3.4028235e38F;
  const double near = std::nextafter(-9999.0F, 0.0F);
  const double further = std::nextafter(std::nextafter(-9999.0F, 0.0F), 0.0F);
  const auto dem = open({.cols = 4,
                         .rows = 1,
                         .type = GDT_Float32,
                         .values = {-9999, near, further, 5},
                         .nodata = -9999});
  EXPECT_THAT(read_all(*dem), ElementsAre(NanSensitiveFloatEq(kNone), NanSensitiveFloatEq(kNone),
                                          static_cast<float>(further), 5));
  const auto far = open({.cols = 2,
                         .rows = 1,
                         .type = GDT_Float32,
                         .values = {static_cast<double>(nodata), 5},
                         .nodata = -3.40282346639e38});
  EXPECT_THAT(read_all(*far), ElementsAre(NanSensitiveFloatEq(kNone), 5));
}

TEST_F(DemTest, NanIsNoDataAndOptionAddsToTheDeclaredValue) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto dem = open(
      {.cols = 4, .rows = 1, .type = GDT_Float64, .values = {nan, -9999, 0, 8}, .nodata = -9999},
      {.nodata = 0});
  EXPECT_THAT(read_all(*dem), ElementsAre(NanSensitiveFloatEq(kNone), NanSensitiveFloatEq(kNone),
                                          NanSensitiveFloatEq(kNone), 8));
}

TEST_F(DemTest, NodataThatTheTypeCannotHoldMatchesNothing) {
  const auto dem =
      open({.cols = 3, .rows = 1, .type = GDT_Byte, .values = {0, 241, 255}}, {.nodata = -9999});
  EXPECT_THAT(read_all(*dem), ElementsAre(0, 241, 255));
  const auto half = open({.cols = 2, .rows = 1, .values = {0, 1}}, {.nodata = 0.5});
  EXPECT_THAT(read_all(*half), ElementsAre(0, 1));
}

TEST_F(DemTest, UndeclaredSpellingsAreKeptAndNamed) {
  for (const double spelling : {-32768.0, -32767.0, -9999.0}) {
    const auto dem = open({.cols = 3, .rows = 1, .values = {1, spelling, spelling}});
    EXPECT_THAT(read_all(*dem), ElementsAre(1, spelling, spelling));
    EXPECT_THAT(dem->georef().notes,
                Contains(HasSubstr("2 of 3 posts read hold " +
                                   std::to_string(static_cast<int>(spelling)))));
    const auto declared =
        open({.cols = 3, .rows = 1, .values = {1, spelling, spelling}, .nodata = spelling});
    EXPECT_THAT(declared->georef().notes, IsEmpty());
  }
}

TEST_F(DemTest, InfiniteAndImplausibleValuesAreNoDataAndCounted) {
  const auto dem =
      open({.cols = 5,
            .rows = 1,
            .type = GDT_Float32,
            .values = {1e20, -3.4e38, std::numeric_limits<double>::infinity(), 999999, -1000001}});
  EXPECT_THAT(read_all(*dem),
              ElementsAre(NanSensitiveFloatEq(kNone), NanSensitiveFloatEq(kNone),
                          NanSensitiveFloatEq(kNone), 999999, NanSensitiveFloatEq(kNone)));
  EXPECT_THAT(dem->georef().notes, Contains(HasSubstr("4 of 5 posts read are infinite")));
}

TEST_F(DemTest, NotesCountEachRowOnce) {
  GridFile grid{.cols = 2, .rows = 3000, .values = {5, 5}};
  grid.values.resize(6000, 5);
  grid.values[5999] = -9999;
  const auto dem = open(grid);
  for (int pass = 0; pass < 2; ++pass) read_all(*dem);
  EXPECT_THAT(dem->georef().notes, Contains(HasSubstr("1 of 6000 posts read hold -9999")));
}

TEST_F(DemTest, UnitsOfFileAndOption) {
  struct Case {
    const char* name;
    double metres;
  };
  for (const Case& c : {Case{"ft", 0.3048}, Case{"feet", 0.3048}, Case{"m", 1}, Case{"Metre", 1},
                        Case{"us-ft", 1200.0 / 3937}, Case{"US survey foot", 1200.0 / 3937}}) {
    SCOPED_TRACE(c.name);
    const auto dem = open({.cols = 1, .rows = 1, .values = {1000}, .unit = c.name});
    EXPECT_THAT(read_all(*dem), ElementsAre(FloatEq(static_cast<float>(1000 * c.metres))));
    EXPECT_DOUBLE_EQ(dem->lattice().step_m, c.metres);
  }
  const auto odd = open({.cols = 1, .rows = 1, .values = {3}, .unit = "fathom"});
  EXPECT_THAT(odd->georef().notes, Contains(HasSubstr("fathom")));
  const auto option =
      open({.cols = 1, .rows = 1, .values = {1000}, .unit = "m"}, {.unit = Unit::Foot});
  EXPECT_THAT(read_all(*option), ElementsAre(FloatEq(304.8F)));
}

TEST_F(DemTest, VerticalScaleMultipliesLast) {
  const auto dem =
      open({.cols = 2, .rows = 1, .values = {100, -9999}, .nodata = -9999, .unit = "ft"},
           {.z_scale = 2});
  EXPECT_THAT(read_all(*dem), ElementsAre(FloatEq(60.96F), NanSensitiveFloatEq(kNone)));
  EXPECT_DOUBLE_EQ(dem->lattice().step_m, 0.6096);
  write_grid(dir_ / "z.tif", {});
  EXPECT_EQ(code_of({dir_ / "z.tif"}, {.z_scale = 0}), ErrorCode::Usage);
}

TEST_F(DemTest, LatticeHoldsForEveryHeight) {
  std::mt19937 random(3);
  for (const double scale : {1.0, 0.1, 0.25, 0.001}) {
    std::vector<double> values(64);
    for (double& v : values) v = static_cast<double>(static_cast<int>(random() % 60000) - 30000);
    const auto dem = open({.cols = 8, .rows = 8, .values = values, .scale = scale, .offset = 12.5});
    const HeightLattice lattice = dem->lattice();
    ASSERT_TRUE(lattice.integer);
    const std::vector<float> heights = read_all(*dem);
    for (std::size_t i = 0; i < heights.size(); ++i) {
      const double n = (static_cast<double>(heights[i]) - lattice.offset_m) / lattice.step_m;
      EXPECT_EQ(std::round(n), values[i]);
    }
  }
}

TEST_F(DemTest, NoLatticeWhereFloatCannotTellItsPointsApart) {
  EXPECT_FALSE(open({.type = GDT_Int32, .scale = 0.001})->lattice().integer);
  EXPECT_FALSE(open({.type = GDT_Int16, .scale = 0.001, .offset = 900000})->lattice().integer);
}

TEST_F(DemTest, PostIsThePixelCentreForAreaAndPoint) {
  for (const char* kind : {"AREA", "POINT"}) {
    const auto file = dir_ / (std::string(kind) + ".tif");
    write_grid(file, {});
    {
      const GDALDatasetUniquePtr dataset(
          GDALDataset::Open(file.c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE));
      dataset->SetMetadataItem("AREA_OR_POINT", kind[0] == 'A' ? "Area" : "Point");
    }
    const Georef georef = open_dem({file})->georef();
    EXPECT_EQ(georef.crs_from_post.apply(0, 0), glm::dvec2(500015, 3999985)) << kind;
    EXPECT_EQ(georef.world_from_post, (Affine2{{30, 0, 0, 0, -30, 0}}));
    EXPECT_EQ(georef.crs_name, "WGS 84 / UTM zone 11N (EPSG:32611)");
  }
}

TEST_F(DemTest, SouthUpAndMirroredGridsAreTurned) {
  const auto south = open({.geotransform = {500000, 30, 0, 3999910, 0, 30}});
  EXPECT_THAT(read_all(*south), ElementsAre(9, 10, 11, 12, 5, 6, 7, 8, 1, 2, 3, 4));
  EXPECT_EQ(south->georef().crs_from_post.apply(0, 0), glm::dvec2(500015, 3999985));
  EXPECT_EQ(south->georef().world_from_post, (Affine2{{30, 0, 0, 0, -30, 0}}));
  const auto west = open({.geotransform = {500120, -30, 0, 4000000, 0, -30}});
  EXPECT_THAT(read_all(*west), ElementsAre(4, 3, 2, 1, 8, 7, 6, 5, 12, 11, 10, 9));
  EXPECT_EQ(west->georef().crs_from_post.apply(0, 0), glm::dvec2(500015, 3999985));
}

TEST_F(DemTest, RotationAndShearAreKept) {
  const auto dem = open({.geotransform = {500000, 26, 15, 4000000, 15, -26}});
  EXPECT_EQ(dem->georef().world_from_post, (Affine2{{26, 15, 0, 15, -26, 0}}));
  EXPECT_EQ(dem->georef().crs_from_post.apply(0, 0), glm::dvec2(500020.5, 3999994.5));
}

TEST_F(DemTest, ProjectedUnitsBecomeMetres) {
  const auto dem = open({.geotransform = {0, 100, 0, 0, 0, -100}, .crs = "EPSG:2263"});
  const auto& m = dem->georef().world_from_post.m;
  EXPECT_NEAR(m[0], 100 * 1200.0 / 3937, 1e-9);
  EXPECT_NEAR(m[4], -100 * 1200.0 / 3937, 1e-9);
}

TEST_F(DemTest, DegreesBecomeMetresAtTheCentreLatitude) {
  const double arc = 1.0 / 1200;
  const auto dem = open({.cols = 3,
                         .rows = 3,
                         .values = {1},
                         .geotransform = {189.5, arc, 0, 60 + 1.5 * arc, 0, -arc},
                         .crs = "EPSG:4326"});
  const auto& m = dem->georef().world_from_post.m;
  const double step = 6378137 * arc * M_PI / 180;
  EXPECT_NEAR(m[0], step * 0.5, 1e-6);
  EXPECT_NEAR(m[4], -step, 1e-6);
  EXPECT_NEAR(dem->georef().crs_from_post.m[2], 189.5 + arc / 2, 1e-12) << "past 180 is kept";
}

TEST_F(DemTest, OtherBodiesHaveTheirOwnRadius) {
  const auto dem = open({.cols = 3,
                         .rows = 3,
                         .values = {1},
                         .geotransform = {10, 0.25, 0, 0.375, 0, -0.25},
                         .crs = "GEOGCS[\"Mars 2000\",DATUM[\"D_Mars_2000\",SPHEROID[\"Mars_2000\","
                                "3396190,169.89]],PRIMEM[\"Reference_Meridian\",0],"
                                "UNIT[\"degree\",0.0174532925199433]]"});
  EXPECT_NEAR(dem->georef().world_from_post.m[0], 3396190 * 0.25 * M_PI / 180, 1e-3);
}

TEST_F(DemTest, WebMercatorIsShrunkToTrueLength) {
  const double y60 = 6378137 * std::log(std::tan(M_PI / 4 + M_PI / 6));
  const auto dem = open({.cols = 3,
                         .rows = 3,
                         .values = {1},
                         .geotransform = {0, 100, 0, y60 + 150, 0, -100},
                         .crs = "EPSG:3857"});
  EXPECT_NEAR(dem->georef().world_from_post.m[0], 50, 1e-6);
  EXPECT_NEAR(dem->georef().world_from_post.m[4], -50, 1e-6);
}

TEST_F(DemTest, ImpossibleGeotransformsGiveOneMetreAndANote) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::vector<double>> cases = {
      {}, {nan, 30, 0, 0, 0, -30}, {0, 30, 0, 0, 30, 0}, {0, HUGE_VAL, 0, 0, 0, -30}};
  for (const auto& gt : cases) {
    const auto dem = open({.geotransform = gt});
    EXPECT_EQ(dem->georef().world_from_post, Affine2{});
    EXPECT_THAT(dem->georef().notes, Contains(HasSubstr("1 m apart")));
  }
}

TEST_F(DemTest, SourceCrsReplacesTheFiles) {
  const double arc = 1.0 / 1200;
  const GridFile grid{.geotransform = {-106, arc, 0, 38, 0, -arc}, .crs = ""};
  const auto assumed = open(grid);
  EXPECT_EQ(assumed->georef().crs_name, "WGS 84 (EPSG:4326)");
  EXPECT_THAT(assumed->georef().notes, Contains(HasSubstr("no CRS")));
  const auto named = open(grid, {.source_crs = "EPSG:4267"});
  EXPECT_EQ(named->georef().crs_name, "NAD27 (EPSG:4267)");
  EXPECT_THAT(named->georef().notes, IsEmpty());
  write_grid(dir_ / "x.tif", grid);
  EXPECT_EQ(code_of({dir_ / "x.tif"}, {.source_crs = "EPSG:none"}), ErrorCode::InvalidInput);
}

TEST_F(DemTest, SeveralBandsGiveTheFirstWithANote) {
  const GridFile grid{.cols = 1, .rows = 1, .bands = 2, .values = {3, 4}};
  const auto first = open(grid);
  EXPECT_THAT(read_all(*first), ElementsAre(3));
  EXPECT_THAT(first->georef().notes, Contains(HasSubstr("2 bands")));
  const auto second = open(grid, {.band = 2});
  EXPECT_THAT(read_all(*second), ElementsAre(4));
  EXPECT_THAT(second->georef().notes, IsEmpty());
  write_grid(dir_ / "b.tif", grid);
  EXPECT_EQ(code_of({dir_ / "b.tif"}, {.band = 3}), ErrorCode::InvalidInput);
}

TEST_F(DemTest, PicturesNeedABandOrAnEncoding) {
  const GridFile grid{.cols = 1,
                      .rows = 1,
                      .bands = 3,
                      .type = GDT_Byte,
                      .values = {1, 134, 160},
                      .options = {"PHOTOMETRIC=RGB"}};
  write_grid(dir_ / "rgb.tif", grid);
  EXPECT_EQ(code_of({dir_ / "rgb.tif"}), ErrorCode::InvalidInput);
  EXPECT_THAT(text_, HasSubstr("--encoding"));
  EXPECT_THAT(read_all(*open(grid, {.band = 2})), ElementsAre(134));
  const auto mapbox = open(grid, {.encoding = Encoding::TerrainRgb});
  EXPECT_THAT(read_all(*mapbox), ElementsAre(FloatEq(0.0F)));
  EXPECT_DOUBLE_EQ(mapbox->lattice().step_m, 0.1);
  EXPECT_DOUBLE_EQ(mapbox->lattice().offset_m, -10000);
}

TEST_F(DemTest, TerrariumAndTransparentPixels) {
  const auto dem = open({.cols = 2,
                         .rows = 1,
                         .bands = 4,
                         .type = GDT_Byte,
                         .values = {128, 128, 10, 10, 64, 0, 255, 0},
                         .options = {"PHOTOMETRIC=RGB", "ALPHA=YES"}},
                        {.encoding = Encoding::Terrarium});
  EXPECT_THAT(read_all(*dem), ElementsAre(10.25F, NanSensitiveFloatEq(kNone)));
  EXPECT_DOUBLE_EQ(dem->lattice().step_m, 1.0 / 256);
}

TEST_F(DemTest, RawFilesBySideOrBySize) {
  const std::vector<std::uint16_t> shorts{1, 2, 300, 65535};
  write_text(dir_ / "a.r16", {reinterpret_cast<const char*>(shorts.data()), 8});
  const auto square = open_dem({dir_ / "a.r16"});
  EXPECT_EQ(square->cols(), 2);
  EXPECT_THAT(read_all(*square), ElementsAre(1, 2, 300, 65535));
  const auto wide = open_dem({dir_ / "a.r16"}, {.raw_size = {{4, 1}}});
  EXPECT_EQ(wide->rows(), 1);
  const std::vector<float> floats{0.5F, -2, kNone};
  write_text(dir_ / "b.r32", {reinterpret_cast<const char*>(floats.data()), 12});
  EXPECT_EQ(code_of({dir_ / "b.r32"}), ErrorCode::InvalidInput);
  const auto column = open_dem({dir_ / "b.r32"}, {.raw_size = {{1, 3}}});
  EXPECT_THAT(read_all(*column), ElementsAre(0.5F, -2, NanSensitiveFloatEq(kNone)));
  EXPECT_EQ(code_of({dir_ / "none.r16"}), ErrorCode::NotFound);
}

TEST_F(DemTest, OptionsThatAFormatHasNoUseForAreUsageErrors) {
  write_text(dir_ / "a.r16", "1234");
  EXPECT_EQ(code_of({dir_ / "a.r16"}, {.band = 1}), ErrorCode::Usage);
  EXPECT_EQ(code_of({dir_ / "a.r16"}, {.encoding = Encoding::Terrarium}), ErrorCode::Usage);
  EXPECT_EQ(code_of({dir_ / "a.r16"}, {.source_crs = "EPSG:4326"}), ErrorCode::Usage);
  write_grid(dir_ / "a.tif", {});
  EXPECT_EQ(code_of({dir_ / "a.tif"}, {.raw_size = {{4, 3}}}), ErrorCode::Usage);
  convert(dir_ / "a.tif", dir_ / "a.png", "PNG");
  EXPECT_EQ(code_of({dir_ / "a.png"}, {.source_crs = "EPSG:4326"}), ErrorCode::InvalidInput);
}

TEST_F(DemTest, OtherFormatsGiveTheSamePosts) {
  GridFile grid{.cols = 20, .rows = 10, .nodata = -9999};
  grid.values.clear();
  for (int i = 0; i < 200; ++i) grid.values.push_back(i % 17 == 0 ? -9999 : 100 + i);
  write_grid(dir_ / "base.tif", grid);
  const std::vector<float> expected = read_all(*open_dem({dir_ / "base.tif"}));
  struct Case {
    const char *driver, *name;
  };
  for (const Case& c : {Case{"AAIGrid", "a.asc"}, Case{"HFA", "b.img"}, Case{"netCDF", "a.nc"},
                        Case{"GSAG", "a.grd"}}) {
    SCOPED_TRACE(c.driver);
    convert(dir_ / "base.tif", dir_ / c.name, c.driver);
    const auto dem = open_dem({dir_ / c.name});
    const std::vector<float> heights = read_all(*dem);
    ASSERT_EQ(heights.size(), expected.size());
    for (std::size_t i = 0; i < heights.size(); ++i) {
      if (std::isnan(expected[i])) {
        EXPECT_TRUE(std::isnan(heights[i])) << i;
      } else {
        EXPECT_EQ(heights[i], expected[i]) << i;
      }
    }
    const Affine2 world = dem->georef().world_from_post;
    EXPECT_NEAR(world.m[0], 30, 1e-6);
    EXPECT_NEAR(world.m[4], -30, 1e-6);
  }
}

TEST_F(DemTest, SideFilesOfEhdrAreFound) {
  const std::vector<std::int16_t> samples{1, 2, -9999, 4, 5, 6};
  write_text(dir_ / "a.bil", {reinterpret_cast<const char*>(samples.data()), 12});
  write_text(dir_ / "a.hdr",
             "BYTEORDER I\nLAYOUT BIL\nNROWS 2\nNCOLS 3\nNBANDS 1\nNBITS 16\nPIXELTYPE SIGNEDINT\n"
             "ULXMAP 100\nULYMAP 200\nXDIM 10\nYDIM 10\nNODATA -9999\n");
  const auto dem = open_dem({dir_ / "a.bil"});
  EXPECT_THAT(read_all(*dem), ElementsAre(1, 2, NanSensitiveFloatEq(kNone), 4, 5, 6));
  EXPECT_EQ(dem->georef().crs_from_post.apply(0, 0), glm::dvec2(100, 200));
  EXPECT_EQ(code_of({dir_ / "a.hdr"}), ErrorCode::Unsupported);
  EXPECT_THAT(text_, HasSubstr("side file"));
  write_text(dir_ / "lone.flt", "1234");
  EXPECT_EQ(code_of({dir_ / "lone.flt"}), ErrorCode::Unsupported);
  EXPECT_THAT(text_, HasSubstr("put lone.hdr beside it"));
}

TEST_F(DemTest, AHeaderBesideAPictureDoesNotMakeItRawSamples) {
  write_text(dir_ / "a.pgm", "P5\n3 2\n255\nabcdef");
  write_text(dir_ / "a.hdr", "ENVI\nsamples = 3\nlines = 2\nbands = 1\ndata type = 1\n");
  EXPECT_THAT(read_all(*open_dem({dir_ / "a.pgm"})), ElementsAre('a', 'b', 'c', 'd', 'e', 'f'));
}

TEST_F(DemTest, MasksWithinAGeotiffSayWhatIsNoData) {
  const auto file = dir_ / "masked.tif";
  write_grid(file, {.values = {1, 2, 3, 4, -9999, 6, 7, 8, 9, 10, 11, 12}});
  {
    CPLSetThreadLocalConfigOption("GDAL_TIFF_INTERNAL_MASK", "YES");
    const GDALDatasetUniquePtr dataset(
        GDALDataset::Open(file.c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE));
    ASSERT_EQ(dataset->CreateMaskBand(GMF_PER_DATASET), CE_None);
    std::vector<std::uint8_t> mask{0, 255, 255, 255, 0, 255, 255, 255, 0, 0, 0, 0};
    ASSERT_EQ(CE_None, dataset->GetRasterBand(1)->GetMaskBand()->RasterIO(
                           GF_Write, 0, 0, 4, 3, mask.data(), 4, 3, GDT_Byte, 0, 0, nullptr));
    CPLSetThreadLocalConfigOption("GDAL_TIFF_INTERNAL_MASK", nullptr);
  }
  const auto none = NanSensitiveFloatEq(kNone);
  const auto dem = open_dem({file});
  EXPECT_THAT(read_all(*dem), ElementsAre(none, 2, 3, 4, none, 6, 7, 8, none, none, none, none));
  EXPECT_THAT(dem->georef().notes, IsEmpty()) << "nothing is said of what lies under the mask";
}

TEST_F(DemTest, TransparentPostsAreNoData) {
  const auto dem = open({.cols = 2,
                         .rows = 1,
                         .bands = 2,
                         .type = GDT_UInt16,
                         .values = {5, 6, 65535, 0},
                         .options = {"ALPHA=YES"}});
  EXPECT_THAT(read_all(*dem), ElementsAre(5, NanSensitiveFloatEq(kNone)));
}

class ZipTest : public DemTest {
 protected:
  struct Member {
    std::string name;
    std::filesystem::path content;
  };
  std::filesystem::path zip(const std::string& archive, const std::vector<Member>& members) {
    void* file = CPLCreateZip((dir_ / archive).c_str(), nullptr);
    for (const Member& member : members) {
      std::ifstream in(member.content, std::ios::binary);
      const std::string bytes{std::istreambuf_iterator<char>(in), {}};
      CPLCreateFileInZip(file, member.name.c_str(), nullptr);
      CPLWriteFileInZip(file, bytes.data(), static_cast<int>(bytes.size()));
      CPLCloseFileInZip(file);
    }
    CPLCloseZip(file);
    return dir_ / archive;
  }
};

TEST_F(ZipTest, ADemOpensIfItIsTheOnlyOne) {
  const auto in = dir_ / "in.tif";
  write_grid(in, {});
  write_text(dir_ / "readme.txt", "read me");
  const auto one = zip("one.zip", {{"readme.txt", dir_ / "readme.txt"}, {"deep/dem.tif", in}});
  EXPECT_EQ(read_all(*open_dem({one})), read_all(*open_dem({in})));
  EXPECT_EQ(code_of({zip("two.zip", {{"a.tif", in}, {"b.tif", in}})}), ErrorCode::InvalidInput);
  EXPECT_THAT(text_, HasSubstr("2 DEM files inside"));
  EXPECT_EQ(code_of({zip("none.zip", {{"r.txt", dir_ / "readme.txt"}})}), ErrorCode::InvalidInput);
  write_text(dir_ / "broken.zip", "PK no archive");
  EXPECT_EQ(code_of({dir_ / "broken.zip"}), ErrorCode::InvalidInput);
}

TEST_F(ZipTest, SideFilesInTheArchiveAreFound) {
  write_text(dir_ / "in.bil", "abcdef");
  write_text(dir_ / "in.hdr",
             "NROWS 2\nNCOLS 3\nNBITS 8\nULXMAP 100\nULYMAP 200\nXDIM 10\nYDIM 10\n");
  const auto dem =
      open_dem({zip("bil.zip", {{"d/in.bil", dir_ / "in.bil"}, {"d/in.hdr", dir_ / "in.hdr"}})});
  EXPECT_THAT(read_all(*dem), ElementsAre('a', 'b', 'c', 'd', 'e', 'f'));
  EXPECT_EQ(dem->georef().crs_from_post.apply(0, 0), glm::dvec2(100, 200));
}

TEST_F(ZipTest, ArchivesInArchivesAndNamesThatLeadOutAreRefused) {
  const auto in = dir_ / "in.tif";
  write_grid(in, {});
  const auto inner = zip("inner.zip", {{"dem.tif", in}});
  EXPECT_EQ(code_of({zip("nested.zip", {{"inner.zip", inner}})}), ErrorCode::InvalidInput);
  for (const char* name : {"../dem.tif", "/etc/dem.tif", "a/../../dem.tif", "a:b.tif",
                           "x/vsicurl/http/dem.tif", "dem.vrt", "dem.nc"}) {
    SCOPED_TRACE(name);
    EXPECT_EQ(code_of({zip("hostile.zip", {{name, in}})}), ErrorCode::InvalidInput);
    VSIUnlink((dir_ / "hostile.zip").c_str());
  }
}

// A row of a file cut short is whole or refused, however often and in whatever order it is asked
// for. (GDAL 3.6 itself gives a failed tile as zeros the second time it is asked for.)
TEST_F(DemTest, RowsOfAFileCutShortAreNeverWrong) {
  constexpr int kSide = 700;
  GridFile grid{.cols = kSide, .rows = kSide, .values = {}};
  std::mt19937 random(11);
  for (int i = 0; i < kSide * kSide; ++i) {
    grid.values.push_back(1 + static_cast<double>(random() % 3000));
  }
  write_grid(dir_ / "whole.tif", grid);
  // A copy has its directory in front, so that it opens when it is cut.
  convert(dir_ / "whole.tif", dir_ / "d.tif", "GTiff",
          {"COMPRESS=DEFLATE", "TILED=YES", "BLOCKXSIZE=128", "BLOCKYSIZE=128"});
  std::filesystem::resize_file(dir_ / "d.tif", std::filesystem::file_size(dir_ / "d.tif") / 2);
  const auto dem = open_dem({dir_ / "d.tif"});
  int good = 0, refused = 0;
  std::vector<float> row(kSide);
  for (int pass = 0; pass < 3; ++pass) {
    for (int i = 0; i < kSide; ++i) {
      const int r = pass == 1 ? kSide - 1 - i : i;
      try {
        dem->read_row(r, row);
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Corrupt);
        EXPECT_THAT(error.what(), HasSubstr("d.tif: row " + std::to_string(r) + " "));
        ++refused;
        continue;
      }
      ++good;
      for (std::size_t c = 0; c < kSide; ++c) {
        ASSERT_EQ(row[c], grid.values[static_cast<std::size_t>(r) * kSide + c]) << r << ' ' << c;
      }
    }
  }
  EXPECT_GE(refused, 3 * 100);
  EXPECT_GE(good, 3 * 128);
}

TEST_F(DemTest, AbsentAndForeignFilesAreRefused) {
  EXPECT_EQ(code_of({dir_ / "none.tif"}), ErrorCode::NotFound);
  EXPECT_EQ(code_of({dir_.path()}), ErrorCode::InvalidInput);
  write_text(dir_ / "t.tif", "not a picture");
  EXPECT_EQ(code_of({dir_ / "t.tif"}), ErrorCode::Unsupported);
  write_grid(dir_ / "big.tif", {.cols = 100, .rows = 2});
  EXPECT_EQ(code_of({dir_ / "big.tif"}, {.max_side = 99}), ErrorCode::Limit);
  EXPECT_EQ(code_of({}), ErrorCode::Usage);
}

}  // namespace
}  // namespace arete::raster
