#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gdal_priv.h>

namespace arete::raster {

struct DatasetCloser {
  void operator()(GDALDataset* dataset) const;
};
using Dataset = std::unique_ptr<GDALDataset, DatasetCloser>;

/// Registers the named drivers, switches networks and side files off, silences GDAL. Idempotent;
/// every entry of this room calls it first. Safe from several threads.
void raise_fence();

/// Lets GDAL's block cache hold an eighth of a memory limit, 16 to 128 MiB.
void limit_block_cache(std::size_t memory_limit);

/// Collects what GDAL says on this thread while it lives; the innermost one hears.
class Messages {
 public:
  Messages();
  ~Messages();
  Messages(const Messages&) = delete;
  Messages& operator=(const Messages&) = delete;
  /// The first failure in one line, else the last warning, else `otherwise`; without the folders of
  /// absolute paths.
  std::string text(const std::string& otherwise) const;
  bool failed() const { return !failure_.empty(); }

 private:
  static void hear(CPLErr level, CPLErrorNum number, const char* text);
  std::string failure_, warning_;
};

enum class Purpose { Dem, Picture };

/// The name for messages: the last component of the path.
std::string display_name(const std::filesystem::path& file);

/// Opens a regular local file with the drivers of `purpose` only; a .zip through its one raster
/// member; a netCDF of several variables through its largest two-dimensional one (then *note
/// says so). Throws: NotFound, Unsupported, InvalidInput, Limit.
Dataset open_fenced(const std::filesystem::path& file, Purpose purpose, std::string* note);

/// The mask, or alpha, that a GeoTIFF keeps within it for all bands; null when there is none. A
/// mask that only repeats a band's nodata value is none.
GDALRasterBand* file_mask(GDALDataset& dataset, int band);

/// Throws unless sides are within 1..max_side and the blocks of the first `bands` bands are of a
/// real type and at most 64 MiB each. Throws: Limit, Unsupported, InvalidInput.
void check_shape(GDALDataset& dataset, int max_side, const std::string& name);

}  // namespace arete::raster
