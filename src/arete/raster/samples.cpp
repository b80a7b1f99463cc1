#include "arete/raster/samples.h"

#include <bit>
#include <cstdint>
#include <fstream>
#include <utility>

#include <cpl_conv.h>
#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::raster {
namespace {

static_assert(std::endian::native == std::endian::little, "raw files are read as they lie");

[[noreturn]] void throw_corrupt(const std::string& name, int row, const std::string& why) {
  throw Error(ErrorCode::Corrupt,
              fmt::format("{}: row {} cannot be read ({}): the file is damaged or cut short; fetch "
                          "it again",
                          name, row, why));
}

// GDAL_NUM_THREADS for what this thread opens while it lives.
class ThreadOption {
 public:
  explicit ThreadOption(const char* threads) {
    CPLSetThreadLocalConfigOption("GDAL_NUM_THREADS", threads);
  }
  ~ThreadOption() { CPLSetThreadLocalConfigOption("GDAL_NUM_THREADS", nullptr); }
  ThreadOption(const ThreadOption&) = delete;
  ThreadOption& operator=(const ThreadOption&) = delete;
};

class GdalSamples final : public Samples {
 public:
  GdalSamples(Dataset dataset, std::vector<int> bands, std::string name,
              std::function<Dataset()> open)
      : dataset_(std::move(dataset)),
        bands_(std::move(bands)),
        name_(std::move(name)),
        open_(std::move(open)) {
    GDALRasterBand& band = *dataset_->GetRasterBand(bands_.front());
    type_ = band.GetRasterDataType();
    int width = 0;
    band.GetBlockSize(&width, &block_rows_);
  }

  int block_rows() const override { return block_rows_; }

  void read(int first, int rows, std::byte* out) override {
    std::string why;
    if (try_read(first, rows, out, why)) return;
    reopen_single_threaded();
    // Row by row, so that what is whole is delivered and the message names the first bad row.
    const auto row_bytes = static_cast<std::size_t>(dataset_->GetRasterXSize()) * sample_bytes();
    for (int r = 0; r < rows; ++r) {
      std::byte* const row = out + static_cast<std::size_t>(r) * row_bytes;
      if (!try_read(first + r, 1, row, why)) throw_corrupt(name_, first + r, why);
    }
  }

 private:
  std::size_t sample_bytes() const {
    return bands_.size() * static_cast<std::size_t>(GDALGetDataTypeSizeBytes(type_));
  }

  bool try_read(int first, int rows, std::byte* out, std::string& why) {
    const Messages messages;
    const int cols = dataset_->GetRasterXSize();
    const auto pixel = static_cast<GSpacing>(sample_bytes());
    const CPLErr result = dataset_->RasterIO(
        GF_Read, 0, first, cols, rows, out, cols, rows, type_, static_cast<int>(bands_.size()),
        bands_.data(), pixel, pixel * cols, GDALGetDataTypeSizeBytes(type_), nullptr);
    why = messages.text("no reason given");
    return result == CE_None && !messages.failed();
  }

  // GDAL 3.6 decodes GeoTIFF tiles on two threads; a tile that failed there stays in its cache as
  // if it were whole, and a second read gives whatever lies in it. Never read that dataset again.
  void reopen_single_threaded() {
    if (single_threaded_ && dataset_) return;
    dataset_.reset();
    const ThreadOption one("1");
    dataset_ = open_();
    single_threaded_ = true;
  }

  Dataset dataset_;
  std::vector<int> bands_;
  std::string name_;
  std::function<Dataset()> open_;
  bool single_threaded_ = false;
  GDALDataType type_ = GDT_Unknown;
  int block_rows_ = 1;
};

class RawSamples final : public Samples {
 public:
  RawSamples(const std::filesystem::path& file, int cols, int sample_bytes)
      : stream_(file, std::ios::binary),
        name_(display_name(file)),
        row_bytes_(std::int64_t{cols} * sample_bytes) {
    if (!stream_) {
      throw Error(ErrorCode::Io, fmt::format("{}: cannot be opened: check its rights", name_));
    }
  }

  int block_rows() const override { return 1; }

  void read(int first, int rows, std::byte* out) override {
    stream_.clear();
    stream_.seekg(first * row_bytes_);
    stream_.read(reinterpret_cast<char*>(out), rows * row_bytes_);
    if (!stream_) throw_corrupt(name_, first, "unexpected end");
  }

 private:
  std::ifstream stream_;
  std::string name_;
  std::int64_t row_bytes_;
};

}  // namespace

std::unique_ptr<Samples> gdal_samples(Dataset dataset, std::vector<int> bands, std::string name,
                                      std::function<Dataset()> open) {
  return std::make_unique<GdalSamples>(std::move(dataset), std::move(bands), std::move(name),
                                       std::move(open));
}

std::unique_ptr<Samples> raw_samples(const std::filesystem::path& file, int cols,
                                     int sample_bytes) {
  return std::make_unique<RawSamples>(file, cols, sample_bytes);
}

}  // namespace arete::raster
