#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "arete/core/height_source.h"
#include "arete/raster/dem.h"
#include "arete/raster/placement.h"
#include "arete/raster/samples.h"
#include "arete/raster/values.h"

namespace arete::raster {

/// How a file's samples become heights: a rule for one band, or an encoding of three or four.
struct SampleFormat {
  ValueRule rule;
  Encoding encoding = Encoding::None;
  int bands = 1;
  std::size_t sample_bytes() const;
};

/// The grid of one DEM file. Notes of georef() may grow while rows are read.
class DemFile final : public HeightSource {
 public:
  struct Parts {
    std::string name;    ///< the file's own
    std::string driver;  ///< for people
    int cols = 0, rows = 0;
    SampleFormat format;
    Placement placement;
    std::unique_ptr<Samples> samples;
    std::function<std::unique_ptr<Samples>()> reopen;  ///< gives them again after release()
    std::size_t buffer_bytes = 0;                      ///< rows are read in chunks of about this
  };
  explicit DemFile(Parts parts);

  int cols() const override { return parts_.cols; }
  int rows() const override { return parts_.rows; }
  Georef georef() const override;
  void read_row(int r, std::span<float> row) override;
  HeightLattice lattice() const override;
  std::string description() const override;
  /// Closes the file and frees the buffer until the next read_row.
  void release();
  /// Closes it, too; from now on rows are read in chunks of about so many bytes.
  void read_in_chunks_of(std::size_t bytes);
  bool holds_memory() const { return parts_.samples != nullptr; }
  bool located() const { return parts_.placement.located; }
  const std::string& name() const { return parts_.name; }

 private:
  void survey();
  void load_chunk_of(int source_row);
  void read_rows(int first, int count);
  void decode_row(int source_row, std::span<float> row);

  Parts parts_;
  std::size_t row_bytes_ = 0, held_row_bytes_ = 0;  ///< samples; with their mask
  int block_rows_ = 1, chunk_rows_ = 1;
  int loaded_first_ = 0, loaded_rows_ = 0;
  std::vector<std::byte> buffer_, mask_;
  Tally tally_;
  std::vector<bool> counted_;  ///< rows that are in tally_
};

/// Opens one file. Throws: as open_dem.
std::unique_ptr<DemFile> open_dem_file(const std::filesystem::path& file, const DemOptions& options,
                                       std::size_t buffer_bytes);

}  // namespace arete::raster
