#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arete/core/height_source.h"
#include "arete/core/raster_source.h"

namespace arete::raster {

enum class Unit { FromFile, Metre, Foot, UsSurveyFoot };
enum class Encoding { None, TerrainRgb, Terrarium };

struct DemOptions {
  int band = 0;  ///< 0 = the first, with a note when there are several
  Encoding encoding = Encoding::None;
  Unit unit = Unit::FromFile;
  std::optional<double> nodata{};  ///< besides what the file declares
  double z_scale = 1;              ///< vertical exaggeration
  std::string source_crs{};        ///< "EPSG:N" in place of the file's; empty = the file's
  std::string crs{};               ///< reproject to "EPSG:N"; empty = leave the posts as they are
  std::optional<std::pair<int, int>> raw_size{};  ///< columns, rows of .r16/.r32
  int max_side = 1 << 24;
  /// Bytes; reading takes three eighths at most: GDAL's block cache (of the whole process), rows as
  /// the file keeps them, reprojection. Decides no height.
  std::size_t memory_limit = std::size_t{1} << 30U;
};

/// Opens one DEM, or several neighbouring files as one mosaic. Fenced: only the drivers of
/// DESIGN.md section 4, no network, no by-reference files, plain row reads, GDAL silent. Throws:
/// NotFound, Unsupported, InvalidInput, Limit: "FILE: what: what to do".
std::unique_ptr<HeightSource> open_dem(const std::vector<std::filesystem::path>& files,
                                       const DemOptions& options = {});

/// An image as a drape pyramid on the DEM's grid: RGB8, warped when both name a CRS, else stretched
/// over the whole grid. It is kept in memory; Limit when that takes over `memory_limit` bytes.
/// Throws as open_dem.
std::unique_ptr<RasterSource> open_drape(const std::filesystem::path& image, int cols, int rows,
                                         const Georef& georef,
                                         std::size_t memory_limit = std::size_t{1} << 30U);

/// Writes a tiled, compressed GeoTIFF (float32, or int16 where that is lossless). Never over an
/// existing file. Throws: Io; nothing is left then.
void write_geotiff(HeightSource& source, const std::filesystem::path& file);
/// Depths or any float picture, width x height, top row first.
void write_geotiff(const std::filesystem::path& file, int width, int height, const float* values);

}  // namespace arete::raster
