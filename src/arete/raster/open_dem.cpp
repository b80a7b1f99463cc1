#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/raster/dem.h"
#include "arete/raster/dem_file.h"
#include "arete/raster/mosaic.h"
#include "arete/raster/reproject.h"

namespace arete::raster {
namespace {

namespace fs = std::filesystem;

// Rows as the file keeps them: beyond this, more at once do not read faster.
constexpr std::size_t kMostRowBytes = std::size_t{64} << 20U;

bool is_raw(const fs::path& file) {
  return file.extension() == ".r16" || file.extension() == ".r32";
}

bool is_colour(GDALRasterBand& band) {
  const GDALColorInterp meaning = band.GetColorInterpretation();
  return meaning == GCI_RedBand || meaning == GCI_PaletteIndex;
}

void refuse_picture(GDALDataset& dataset, const DemOptions& options, const std::string& name) {
  if (options.band != 0 || options.encoding != Encoding::None) return;
  if (!is_colour(*dataset.GetRasterBand(1))) return;
  throw Error(ErrorCode::InvalidInput,
              fmt::format("{}: a colour picture: name --band, or --encoding terrain-rgb or "
                          "terrarium if its colours encode heights",
                          name));
}

int pick_band(GDALDataset& dataset, const DemOptions& options, const std::string& name,
              std::vector<std::string>& notes) {
  const int count = dataset.GetRasterCount();
  if (options.band < 0 || options.band > count) {
    throw Error(ErrorCode::InvalidInput, fmt::format("{}: no band {}: name one of its {} (--band)",
                                                     name, options.band, count));
  }
  if (options.band == 0 && count > 1) {
    notes.push_back(fmt::format("The file has {} bands: band 1 was read.", count));
  }
  return options.band == 0 ? 1 : options.band;
}

SampleFormat colour_format(GDALDataset& dataset, const DemOptions& options,
                           const std::string& name) {
  const int count = dataset.GetRasterCount();
  bool bytes = count == 3 || count == 4;
  for (int i = 1; i <= count; ++i) {
    bytes = bytes && dataset.GetRasterBand(i)->GetRasterDataType() == GDT_Byte;
  }
  if (!bytes) {
    throw Error(ErrorCode::InvalidInput,
                fmt::format("{}: not 3 or 4 bands of bytes: leave --encoding out", name));
  }
  SampleFormat format;
  format.rule = plain_rule(GDT_Byte, options);
  format.encoding = options.encoding;
  format.bands = count;
  return format;
}

struct Shape {
  int cols, rows;
  GDALDataType type;
};

// The file may have been replaced since it was looked at: buffers are made for `shape`.
Dataset reopen_dataset(const fs::path& file, const std::vector<int>& bands, Shape shape) {
  const std::string name = display_name(file);
  Dataset dataset = open_fenced(file, Purpose::Dem, nullptr);
  const bool same = dataset->GetRasterXSize() == shape.cols &&
                    dataset->GetRasterYSize() == shape.rows &&
                    dataset->GetRasterCount() >= bands.back() &&
                    dataset->GetRasterBand(bands.front())->GetRasterDataType() == shape.type;
  if (!same) {
    throw Error(ErrorCode::Corrupt,
                fmt::format("{}: changed while it was read: start again", name));
  }
  check_shape(*dataset, std::max(shape.cols, shape.rows), name);
  return dataset;
}

std::unique_ptr<DemFile> open_gdal(const fs::path& file, const DemOptions& options,
                                   std::size_t buffer_bytes) {
  const std::string name = display_name(file);
  if (options.raw_size) {
    throw Error(
        ErrorCode::Usage,
        fmt::format("{}: says its size itself: leave out --size, which is for .r16 and .r32",
                    name));
  }
  std::string note;
  Dataset dataset = open_fenced(file, Purpose::Dem, &note);
  const Messages messages;
  check_shape(*dataset, options.max_side, name);
  refuse_picture(*dataset, options, name);
  DemFile::Parts parts;
  parts.name = name;
  parts.driver = dataset->GetDriverName();
  parts.cols = dataset->GetRasterXSize();
  parts.rows = dataset->GetRasterYSize();
  parts.buffer_bytes = buffer_bytes;
  parts.placement = place(*dataset, options.source_crs, name);
  std::vector<std::string>& notes = parts.placement.georef.notes;
  if (!note.empty()) notes.push_back(note);
  std::vector<int> bands = {1, 2, 3, 4};
  if (options.encoding != Encoding::None) {
    parts.format = colour_format(*dataset, options, name);
    bands.resize(static_cast<std::size_t>(parts.format.bands));
  } else {
    bands = {pick_band(*dataset, options, name, notes)};
    parts.format.rule = value_rule(*dataset->GetRasterBand(bands.front()), options, name, notes);
  }
  const Shape shape{parts.cols, parts.rows, parts.format.rule.type};
  const auto open = [file, bands, shape] { return reopen_dataset(file, bands, shape); };
  parts.reopen = [bands, name, open] { return gdal_samples(open(), bands, name, open); };
  parts.samples = gdal_samples(std::move(dataset), bands, name, open);
  return std::make_unique<DemFile>(std::move(parts));
}

std::pair<int, int> raw_shape(const fs::path& file, const DemOptions& options, int sample_bytes) {
  const std::string name = display_name(file);
  std::error_code error;
  const auto bytes = static_cast<std::int64_t>(fs::file_size(file, error));
  if (error)
    throw Error(ErrorCode::NotFound, fmt::format("{}: no such file: check the path", name));
  const auto side =
      static_cast<std::int64_t>(std::llround(std::sqrt(static_cast<double>(bytes) / sample_bytes)));
  std::pair<std::int64_t, std::int64_t> shape{side, side};
  if (options.raw_size) shape = *options.raw_size;
  const auto [cols, rows] = shape;
  if (cols < 1 || rows < 1 || cols > options.max_side || rows > options.max_side ||
      cols * rows * sample_bytes != bytes) {
    throw Error(ErrorCode::InvalidInput,
                fmt::format("{}: {} bytes are not {} x {} samples of {}: name its size (--size)",
                            name, bytes, cols, rows, sample_bytes));
  }
  return {static_cast<int>(cols), static_cast<int>(rows)};
}

void refuse_options_of_formats(const fs::path& file, const DemOptions& options) {
  if (options.band == 0 && options.encoding == Encoding::None && options.source_crs.empty()) return;
  throw Error(ErrorCode::Usage,
              fmt::format("{}: raw samples have one band, no colours and no place: leave out "
                          "--band, --encoding and --source-crs",
                          display_name(file)));
}

std::unique_ptr<DemFile> open_raw(const fs::path& file, const DemOptions& options,
                                  std::size_t buffer_bytes) {
  refuse_options_of_formats(file, options);
  const bool integer = file.extension() == ".r16";
  const int sample_bytes = integer ? 2 : 4;
  DemFile::Parts parts;
  parts.name = display_name(file);
  parts.driver = integer ? "raw uint16" : "raw float32";
  std::tie(parts.cols, parts.rows) = raw_shape(file, options, sample_bytes);
  parts.buffer_bytes = buffer_bytes;
  parts.format.rule = plain_rule(integer ? GDT_UInt16 : GDT_Float32, options);
  parts.placement.georef = unit_georef();
  parts.placement.georef.notes.emplace_back("Raw samples say no spacing: 1 m was assumed.");
  parts.placement.located = false;
  parts.reopen = [file, cols = parts.cols, sample_bytes] {
    return raw_samples(file, cols, sample_bytes);
  };
  parts.samples = parts.reopen();
  return std::make_unique<DemFile>(std::move(parts));
}

std::unique_ptr<HeightSource> open_posts(const std::vector<fs::path>& files,
                                         const DemOptions& options) {
  const std::size_t buffer = std::min(kMostRowBytes, options.memory_limit / 16);
  if (files.size() == 1) return open_dem_file(files.front(), options, buffer);
  std::vector<std::unique_ptr<DemFile>> members;
  for (const fs::path& file : files) {
    members.push_back(open_dem_file(file, options, buffer));
    members.back()->release();
  }
  return make_mosaic(std::move(members), options.max_side, buffer);
}

}  // namespace

std::unique_ptr<DemFile> open_dem_file(const fs::path& file, const DemOptions& options,
                                       std::size_t buffer_bytes) {
  return is_raw(file) ? open_raw(file, options, buffer_bytes)
                      : open_gdal(file, options, buffer_bytes);
}

std::unique_ptr<HeightSource> open_dem(const std::vector<fs::path>& files,
                                       const DemOptions& options) {
  if (files.empty()) throw Error(ErrorCode::Usage, "no DEM file was named");
  if (!std::isfinite(options.z_scale) || options.z_scale == 0) {
    throw Error(ErrorCode::Usage, "the vertical scale must be a number other than 0");
  }
  raise_fence();
  limit_block_cache(options.memory_limit);
  std::unique_ptr<HeightSource> source = open_posts(files, options);
  if (options.crs.empty()) return source;
  return reproject(std::move(source), display_name(files.front()), options);
}

}  // namespace arete::raster
