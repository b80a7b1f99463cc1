#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "arete/raster/fence.h"

namespace arete::raster {

/// Undecoded rows of a grid, as the file keeps them (host byte order), band-interleaved by sample.
class Samples {
 public:
  virtual ~Samples() = default;
  /// Rows [first, first + rows) into `out`. Throws: Corrupt naming the row.
  virtual void read(int first, int rows, std::byte* out) = 0;
  /// True when the file says for each sample, in a mask of its own, whether it is data.
  virtual bool masked() const { return false; }
  /// The mask of rows [first, first + rows): a byte a sample, 0 = no data. Requires: masked().
  /// Throws: Corrupt naming the row.
  virtual void read_mask(int, int, std::byte*) {}
  /// Rows that are cheapest to read together.
  virtual int block_rows() const = 0;
};

/// Full-width rows of `bands` (1-based, of one type) of an open file; never decimated, so that
/// overviews and what they may refer to are not touched. Masks are those within a GeoTIFF, alpha
/// too. `open` gives the same file afresh, once a
/// read has failed.
std::unique_ptr<Samples> gdal_samples(Dataset dataset, std::vector<int> bands, std::string name,
                                      std::function<Dataset()> open);

/// Little-endian samples of `sample_bytes` bytes without a header. Throws: Io.
std::unique_ptr<Samples> raw_samples(const std::filesystem::path& file, int cols, int sample_bytes);

}  // namespace arete::raster
