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
        open_(std::move(open)),
        cols_(dataset_->GetRasterXSize()) {
    type_ = first_band().GetRasterDataType();
    masked_ = file_mask(*dataset_, bands_.front()) != nullptr;
    int width = 0;
    first_band().GetBlockSize(&width, &block_rows_);
  }

  int block_rows() const override { return block_rows_; }
  bool masked() const override { return masked_; }

  void read(int first, int rows, std::byte* out) override {
    const auto pixel = static_cast<GSpacing>(sample_bytes());
    read_whole(first, rows, {out, sample_bytes()},
               [this, pixel](int row, int count, std::byte* to) {
                 return dataset_->RasterIO(GF_Read, 0, row, cols_, count, to, cols_, count, type_,
                                           static_cast<int>(bands_.size()), bands_.data(), pixel,
                                           pixel * cols_, GDALGetDataTypeSizeBytes(type_), nullptr);
               });
  }

  void read_mask(int first, int rows, std::byte* out) override {
    read_whole(first, rows, {out, 1}, [this](int row, int count, std::byte* to) {
      return file_mask(*dataset_, bands_.front())
          ->RasterIO(GF_Read, 0, row, cols_, count, to, cols_, count, GDT_Byte, 0, 0, nullptr);
    });
  }

 private:
  struct Output {
    std::byte* bytes;
    std::size_t post_bytes;
  };

  GDALRasterBand& first_band() const { return *dataset_->GetRasterBand(bands_.front()); }

  std::size_t sample_bytes() const {
    return bands_.size() * static_cast<std::size_t>(GDALGetDataTypeSizeBytes(type_));
  }

  template <typename Read>
  void read_whole(int first, int rows, Output out, const Read& read) {
    std::string why;
    if (try_read(read, first, rows, out.bytes, why)) return;
    reopen_single_threaded();
    // Row by row, so that what is whole is delivered and the message names the first bad row.
    for (int r = 0; r < rows; ++r, out.bytes += static_cast<std::size_t>(cols_) * out.post_bytes) {
      if (!try_read(read, first + r, 1, out.bytes, why)) throw_corrupt(name_, first + r, why);
    }
  }

  template <typename Read>
  static bool try_read(const Read& read, int first, int rows, std::byte* out, std::string& why) {
    const Messages messages;
    const CPLErr result = read(first, rows, out);
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
  int cols_;
  bool single_threaded_ = false, masked_ = false;
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
