#include "raster/grid_files.h"

#include <cstdio>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include <cpl_string.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>
#include <stdlib.h>
#include <unistd.h>

#include "arete/raster/fence.h"

namespace arete::raster::testing {
namespace {

GDALDriver& driver_named(const char* name) {
  raise_fence();
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName(name);
  if (driver == nullptr) throw std::runtime_error(std::string("no driver ") + name);
  return *driver;
}

CPLStringList option_list(const std::vector<std::string>& names) {
  CPLStringList options;
  for (const std::string& name : names) options.AddString(name.c_str());
  return options;
}

void describe(GDALDataset& dataset, const GridFile& grid) {
  if (!grid.geotransform.empty()) {
    std::vector<double> gt = grid.geotransform;
    dataset.SetGeoTransform(gt.data());
  }
  if (!grid.crs.empty()) {
    OGRSpatialReference crs;
    crs.SetFromUserInput(grid.crs.c_str());
    crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    dataset.SetSpatialRef(&crs);
  }
  for (int i = 1; i <= grid.bands; ++i) {
    GDALRasterBand& band = *dataset.GetRasterBand(i);
    if (grid.nodata) band.SetNoDataValue(*grid.nodata);
    if (grid.scale) band.SetScale(*grid.scale);
    if (grid.offset) band.SetOffset(*grid.offset);
    if (!grid.unit.empty()) band.SetUnitType(grid.unit.c_str());
  }
}

}  // namespace

TempDir::TempDir() {
  std::string name = (std::filesystem::temp_directory_path() / "arete-raster-XXXXXX").native();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = name;
}

TempDir::~TempDir() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

void write_grid(const std::filesystem::path& file, const GridFile& grid) {
  GDALDriver& driver = driver_named("GTiff");
  const Messages messages;
  const CPLStringList options = option_list(grid.options);
  Dataset dataset(
      driver.Create(file.c_str(), grid.cols, grid.rows, grid.bands, grid.type, options.List()));
  if (!dataset) throw std::runtime_error(messages.text("Create failed"));
  describe(*dataset, grid);
  const auto count = static_cast<std::size_t>(grid.cols) * static_cast<std::size_t>(grid.rows);
  std::size_t next = 0;
  for (int i = 1; i <= grid.bands; ++i) {
    std::vector<double> values(count);
    for (double& v : values) v = grid.values[next++ % grid.values.size()];
    const CPLErr result =
        dataset->GetRasterBand(i)->RasterIO(GF_Write, 0, 0, grid.cols, grid.rows, values.data(),
                                            grid.cols, grid.rows, GDT_Float64, 0, 0, nullptr);
    if (result != CE_None) throw std::runtime_error(messages.text("RasterIO failed"));
  }
}

void convert(const std::filesystem::path& from, const std::filesystem::path& to, const char* driver,
             const std::vector<std::string>& names) {
  const Messages messages;
  GDALDriver& target = driver_named(driver);
  const CPLStringList options = option_list(names);
  const Dataset source(GDALDataset::Open(from.c_str(), GDAL_OF_RASTER));
  const Dataset copy(
      source ? target.CreateCopy(to.c_str(), source.get(), 0, options.List(), nullptr, nullptr)
             : nullptr);
  if (!copy) throw std::runtime_error(messages.text("CreateCopy failed") + " by " + driver);
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

std::vector<float> read_all(HeightSource& source) {
  const auto cols = static_cast<std::size_t>(source.cols());
  std::vector<float> all(cols * static_cast<std::size_t>(source.rows()));
  for (int r = 0; r < source.rows(); ++r) {
    source.read_row(r, {&all[cols * static_cast<std::size_t>(r)], cols});
  }
  return all;
}

CapturedStderr::CapturedStderr() {
  std::fflush(stderr);
  kept_ = ::dup(STDERR_FILENO);
  const int file = ::open((folder_ / "stderr").c_str(), O_CREAT | O_WRONLY | O_APPEND, 0600);
  ::dup2(file, STDERR_FILENO);
  ::close(file);
}

CapturedStderr::~CapturedStderr() {
  std::fflush(stderr);
  ::dup2(kept_, STDERR_FILENO);
  ::close(kept_);
}

std::string CapturedStderr::text() const {
  std::fflush(stderr);
  std::ifstream file(folder_ / "stderr");
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace arete::raster::testing
