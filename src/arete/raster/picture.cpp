#include "arete/raster/picture.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/raster/placement.h"
#include "arete/raster/samples.h"

namespace arete::raster {
namespace {

constexpr int kMaxSide = 1 << 20;

using Colour = std::array<std::uint8_t, 3>;

// Bands that say red, green and blue; else the first three, or the first for grey.
std::vector<int> colour_bands(GDALDataset& dataset) {
  const int count = dataset.GetRasterCount();
  std::vector<int> named;
  for (const GDALColorInterp wanted : {GCI_RedBand, GCI_GreenBand, GCI_BlueBand}) {
    for (int i = 1; i <= count; ++i) {
      if (dataset.GetRasterBand(i)->GetColorInterpretation() == wanted) {
        named.push_back(i);
        break;
      }
    }
  }
  if (named.size() == 3) return named;
  return count >= 3 ? std::vector<int>{1, 2, 3} : std::vector<int>{1};
}

std::vector<Colour> palette(GDALRasterBand& band) {
  std::vector<Colour> colours;
  const GDALColorTable* table = band.GetColorTable();
  if (table == nullptr) return colours;
  for (int i = 0; i < table->GetColorEntryCount(); ++i) {
    GDALColorEntry entry;
    table->GetColorEntryAsRGB(i, &entry);
    const auto byte = [](short v) {
      return static_cast<std::uint8_t>(std::clamp<short>(v, 0, 255));
    };
    colours.push_back({byte(entry.c1), byte(entry.c2), byte(entry.c3)});
  }
  return colours;
}

// Samples of a row as colours.
class Reader {
 public:
  explicit Reader(PictureFile& file) : width_(static_cast<std::size_t>(file.width)) {
    std::vector<int> bands = colour_bands(*file.dataset);
    GDALRasterBand& band = *file.dataset->GetRasterBand(bands.front());
    const GDALDataType type = band.GetRasterDataType();
    for (const int i : bands) {
      if (file.dataset->GetRasterBand(i)->GetRasterDataType() != type ||
          (type != GDT_Byte && type != GDT_UInt16)) {
        throw Error(ErrorCode::Unsupported,
                    fmt::format("{}: not a picture of 8 or 16 bits: convert it to PNG", file.name));
      }
    }
    if (bands.size() == 1) palette_ = palette(band);
    sample_bytes_ = type == GDT_Byte ? 1 : 2;
    bands_ = bands.size();
    raw_.resize(width_ * bands_ * sample_bytes_);
    const auto open = [path = file.path] { return open_fenced(path, Purpose::Picture, nullptr); };
    samples_ = gdal_samples(std::move(file.dataset), std::move(bands), file.name, open);
  }

  void read(int row) { samples_->read(row, 1, raw_.data()); }

  Colour operator[](std::size_t x) const {
    if (!palette_.empty()) return palette_[std::min(palette_.size() - 1, code(x))];
    if (bands_ == 1) return {byte(x), byte(x), byte(x)};
    return {byte(3 * x), byte(3 * x + 1), byte(3 * x + 2)};
  }

 private:
  // Host order is little-endian: the high byte of 16 bits comes second.
  std::uint8_t byte(std::size_t i) const {
    return std::to_integer<std::uint8_t>(raw_[i * sample_bytes_ + sample_bytes_ - 1]);
  }
  std::size_t code(std::size_t i) const {
    std::size_t value = std::to_integer<std::size_t>(raw_[i * sample_bytes_]);
    if (sample_bytes_ == 2) value += std::to_integer<std::size_t>(raw_[2 * i + 1]) << 8U;
    return value;
  }

  std::size_t width_, bands_ = 1, sample_bytes_ = 1;
  std::vector<Colour> palette_;
  std::vector<std::byte> raw_;
  std::unique_ptr<Samples> samples_;
};

int shrunk(int side, int shrink) {
  return ((side - 1) >> shrink) + 1;
}

}  // namespace

PictureFile open_picture(const std::filesystem::path& path) {
  PictureFile file;
  file.name = display_name(path);
  file.path = path;
  file.dataset = open_fenced(path, Purpose::Picture, nullptr);
  const Messages messages;
  check_shape(*file.dataset, kMaxSide, file.name);
  file.width = file.dataset->GetRasterXSize();
  file.height = file.dataset->GetRasterYSize();
  const Placement placement = place(*file.dataset, {}, file.name);
  // As the file lies, not turned north-up: rows are read in its own order.
  file.place = {pixel_centres(*file.dataset).value_or(Affine2{}),
                placement.located ? placement.georef.crs : std::string()};
  file.geographic =
      !file.place.crs.empty() && parse_crs(file.place.crs, file.name).IsGeographic() != 0;
  return file;
}

Picture read_picture(PictureFile& file, int shrink) {
  Reader reader(file);
  Picture picture{shrunk(file.width, shrink), shrunk(file.height, shrink), {}};
  const auto row_values = static_cast<std::size_t>(picture.width) * 3;
  picture.rgb.resize(row_values * static_cast<std::size_t>(picture.height));
  std::vector<std::uint32_t> sums(row_values);
  const int block = 1 << shrink;
  for (int y = 0; y < picture.height; ++y) {
    std::fill(sums.begin(), sums.end(), 0U);
    const int end = std::min(file.height, (y + 1) * block);
    for (int row = y * block; row < end; ++row) {
      reader.read(row);
      for (int x = 0; x < file.width; ++x) {
        const Colour colour = reader[static_cast<std::size_t>(x)];
        const auto at = static_cast<std::size_t>(x >> shrink) * 3;
        for (std::size_t k = 0; k < 3; ++k) sums[at + k] += colour[k];
      }
    }
    for (std::size_t i = 0; i < row_values; ++i) {
      const int first = static_cast<int>(i / 3) * block;
      const auto count = static_cast<std::uint32_t>((std::min(file.width, first + block) - first) *
                                                    (end - y * block));
      picture.rgb[row_values * static_cast<std::size_t>(y) + i] =
          static_cast<std::uint8_t>((sums[i] + count / 2) / count);
    }
  }
  return picture;
}

}  // namespace arete::raster
