#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <gdal_priv.h>

#include "arete/core/height_source.h"

namespace arete::raster::testing {

/// A folder of its own, removed with all that is in it.
class TempDir {
 public:
  TempDir();
  ~TempDir();
  TempDir(const TempDir&) = delete;
  TempDir& operator=(const TempDir&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// What a test file is made of; sample i of a band is values[i % values.size()].
struct GridFile {
  int cols = 4, rows = 3, bands = 1;
  GDALDataType type = GDT_Int16;
  std::vector<double> values{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  std::vector<double> geotransform{500000, 30, 0, 4000000, 0, -30};
  std::string crs = "EPSG:32611";
  std::optional<double> nodata{}, scale{}, offset{};
  std::string unit{};
  std::vector<std::string> options{};  ///< creation options "NAME=VALUE"
};

/// Writes it with the GTiff driver.
void write_grid(const std::filesystem::path& file, const GridFile& grid);
/// Copies a GeoTIFF into another format.
void convert(const std::filesystem::path& from, const std::filesystem::path& to, const char* driver,
             const std::vector<std::string>& options = {});
void write_text(const std::filesystem::path& file, const std::string& text);

/// All rows, row-major.
std::vector<float> read_all(HeightSource& source);

/// File descriptor 2 goes into a file while it lives.
class CapturedStderr {
 public:
  CapturedStderr();
  ~CapturedStderr();
  CapturedStderr(const CapturedStderr&) = delete;
  CapturedStderr& operator=(const CapturedStderr&) = delete;
  /// What was written so far.
  std::string text() const;

 private:
  TempDir folder_;
  int kept_ = -1;
};

}  // namespace arete::raster::testing
