#include <cmath>
#include <csignal>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "arete/core/error.h"
#include "arete/core/heightfield.h"
#include "arete/raster/dem.h"
#include "arete/raster/synthetic.h"

#include "raster/grid_files.h"

namespace arete::raster {
namespace {

using namespace testing;  // NOLINT: the room's own helpers

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

bool same(const std::vector<float>& a, const std::vector<float>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!(a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i])))) return false;
  }
  return true;
}

GDALDataType type_of(const std::filesystem::path& file) {
  const GDALDatasetUniquePtr dataset(GDALDataset::Open(file.c_str(), GDAL_OF_RASTER));
  return dataset->GetRasterBand(1)->GetRasterDataType();
}

Heightfield integers(float low, float high) {
  Heightfield field(3, 2);
  field[{0, 0}] = low;
  field[{1, 0}] = high;
  field[{2, 1}] = kNone;
  field.set_lattice({.integer = true, .step_m = 1, .offset_m = 0});
  return field;
}

TEST(WriteGeotiff, FloatsComeBackToTheBit) {
  const TempDir dir;
  const auto source = synthesize(SyntheticKind::Fbm, 300, 1);
  write_geotiff(*source, dir / "a.tif");
  const auto back = open_dem({dir / "a.tif"});
  EXPECT_TRUE(same(read_all(*back), read_all(*source)));
  EXPECT_EQ(back->georef().world_from_post, source->georef().world_from_post);
  EXPECT_EQ(type_of(dir / "a.tif"), GDT_Float32);
}

TEST(WriteGeotiff, IntegersTakeTheSmallestLosslessType) {
  const TempDir dir;
  struct Case {
    float low, high;
    GDALDataType type;
  };
  int n = 0;
  for (const Case& c : {Case{-32767, 32767, GDT_Int16}, Case{-32768, 5, GDT_Int32},
                        Case{0, 40000, GDT_Int32}, Case{-900000, 900000, GDT_Int32}}) {
    Heightfield field = integers(c.low, c.high);
    const auto file = dir / (std::to_string(n++) + ".tif");
    write_geotiff(field, file);
    EXPECT_EQ(type_of(file), c.type);
    const auto back = open_dem({file});
    EXPECT_TRUE(same(read_all(*back), {field.posts().begin(), field.posts().end()}));
    EXPECT_TRUE(back->lattice().integer);
  }
}

TEST(WriteGeotiff, PlaceSurvives) {
  const TempDir dir;
  write_grid(dir / "in.tif", {.geotransform = {500000, 26, 15, 4000000, 15, -26}});
  const auto source = open_dem({dir / "in.tif"});
  write_geotiff(*source, dir / "out.tif");
  const Georef a = source->georef(), b = open_dem({dir / "out.tif"})->georef();
  EXPECT_EQ(a.crs_name, b.crs_name);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_NEAR(a.crs_from_post.m[k], b.crs_from_post.m[k], 1e-6);
  }
}

TEST(WriteGeotiff, PicturesOfFloats) {
  const TempDir dir;
  const std::vector<float> depth{1, 0.5F, kNone, 4, 5, 6};
  write_geotiff(dir / "d.tif", 3, 2, depth.data());
  EXPECT_TRUE(same(read_all(*open_dem({dir / "d.tif"})), depth));
}

TEST(WriteGeotiff, NeverOverAnExistingFile) {
  const TempDir dir;
  write_text(dir / "there.tif", "mine");
  const auto source = synthesize(SyntheticKind::Flat, 4, 1);
  EXPECT_THROW(write_geotiff(*source, dir / "there.tif"), Error);
  std::ifstream file(dir / "there.tif");
  std::string text;
  file >> text;
  EXPECT_EQ(text, "mine");
  std::filesystem::create_symlink(dir / "nowhere", dir / "link.tif");
  EXPECT_THROW(write_geotiff(*source, dir / "link.tif"), Error);
}

TEST(WriteGeotiff, NothingIsLeftAfterAFailure) {
  const TempDir dir;
  const auto count = [&] {
    return std::distance(std::filesystem::directory_iterator(dir.path()),
                         std::filesystem::directory_iterator());
  };
  // A source that breaks off half-way.
  class Broken final : public Heightfield {
   public:
    Broken() : Heightfield(600, 600) {}
    void read_row(int r, std::span<float> row) override {
      if (r > 400) throw Error(ErrorCode::Corrupt, "broken");
      Heightfield::read_row(r, row);
    }
  } broken;
  EXPECT_THROW(write_geotiff(broken, dir / "a.tif"), Error);
  EXPECT_EQ(count(), 0);
  const auto source = synthesize(SyntheticKind::Fbm, 600, 1);
  EXPECT_THROW(write_geotiff(*source, dir / "no such folder" / "a.tif"), Error);

  // A full disk, as far as this process can tell.
  rlimit old{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
  const rlimit small{.rlim_cur = 100000, .rlim_max = old.rlim_max};
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  ::setrlimit(RLIMIT_FSIZE, &small);
  EXPECT_THROW(write_geotiff(*source, dir / "full.tif"), Error);
  ::setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, previous);
  EXPECT_EQ(count(), 0);
  write_geotiff(*source, dir / "full.tif");
  EXPECT_EQ(count(), 1);
}

}  // namespace
}  // namespace arete::raster
