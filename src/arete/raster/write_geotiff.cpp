#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <cpl_string.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "arete/core/error.h"
#include "arete/raster/dem.h"
#include "arete/raster/fence.h"
#include "arete/raster/placement.h"

namespace arete::raster {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBandBytes = std::size_t{64} << 20U;

[[noreturn]] void throw_io(const fs::path& file, const std::string& why) {
  throw Error(
      ErrorCode::Io,
      fmt::format("{}: not written ({}): check the folder and its free space", file.string(), why));
}

// A name beside `file` that nobody uses, removed again unless published.
class Partial {
 public:
  explicit Partial(const fs::path& file) : file_(file), partial_(file) {
    if (fs::symlink_status(file).type() != fs::file_type::not_found) {
      throw Error(ErrorCode::Io, fmt::format("{}: exists already: remove it or choose another name",
                                             file.string()));
    }
    partial_ += fmt::format(".{}.part", ::getpid());
    std::error_code ignored;
    fs::remove(partial_, ignored);  // of a dead process that had our number
  }
  ~Partial() {
    std::error_code ignored;
    fs::remove(partial_, ignored);
  }
  Partial(const Partial&) = delete;
  Partial& operator=(const Partial&) = delete;

  const fs::path& path() const { return partial_; }

  // RENAME_NOREPLACE closes the gap between the check above and now; not every file system has it.
  void publish() const {
    if (::renameat2(AT_FDCWD, partial_.c_str(), AT_FDCWD, file_.c_str(), RENAME_NOREPLACE) == 0) {
      return;
    }
    std::error_code error(errno, std::generic_category());
    if (error == std::errc::invalid_argument) fs::rename(partial_, file_, error);
    if (error) throw_io(file_, error.message());
  }

 private:
  fs::path file_, partial_;
};

struct Picture {
  int cols = 0, rows = 0;
  GDALDataType type = GDT_Float32;
  std::optional<double> nodata;
  const Georef* georef = nullptr;
};

int rows_at_once(int cols) {
  const std::size_t fitting = kBandBytes / (static_cast<std::size_t>(cols) * sizeof(float));
  return static_cast<int>(std::clamp<std::size_t>(fitting / 16 * 16, 16, 256));
}

CPLStringList creation_options(const Picture& picture) {
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  const char* known = driver->GetMetadataItem(GDAL_DMD_CREATIONOPTIONLIST);
  const bool zstd = known != nullptr && std::string_view(known).find("ZSTD") != std::string::npos;
  CPLStringList options;
  options.SetNameValue("COMPRESS", zstd ? "ZSTD" : "DEFLATE");
  options.SetNameValue("PREDICTOR", picture.type == GDT_Float32 ? "3" : "2");
  options.SetNameValue("TILED", "YES");
  options.SetNameValue("BLOCKXSIZE", "256");
  options.SetNameValue("BLOCKYSIZE", fmt::format("{}", rows_at_once(picture.cols)).c_str());
  options.SetNameValue("BIGTIFF", "IF_SAFER");
  return options;
}

void set_georef(GDALDataset& dataset, const Georef& georef) {
  const bool known = !georef.crs.empty();
  const auto& m = known ? georef.crs_from_post.m : georef.world_from_post.m;
  // GDAL wants the corner of pixel (0,0), half a post to the north-west.
  std::array<double, 6> gt = {m[2] - (m[0] + m[1]) / 2, m[0], m[1],
                              m[5] - (m[3] + m[4]) / 2, m[3], m[4]};
  dataset.SetGeoTransform(gt.data());
  if (!known) return;
  const OGRSpatialReference crs = parse_crs(georef.crs, "output");
  dataset.SetSpatialRef(&crs);
}

Dataset create(const fs::path& path, const Picture& picture) {
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  const CPLStringList options = creation_options(picture);
  Dataset dataset(
      driver->Create(path.c_str(), picture.cols, picture.rows, 1, picture.type, options.List()));
  if (!dataset) return dataset;
  if (picture.georef != nullptr) set_georef(*dataset, *picture.georef);
  if (picture.nodata) dataset->GetRasterBand(1)->SetNoDataValue(*picture.nodata);
  return dataset;
}

using FillRow = std::function<void(int row, float* out)>;

// NaN goes to the declared value when the type has no NaN; GDAL rounds and converts the rest.
void write_rows(GDALDataset& dataset, const Picture& picture, const FillRow& fill) {
  const int step = rows_at_once(picture.cols);
  const auto cols = static_cast<std::size_t>(picture.cols);
  std::vector<float> buffer(cols * static_cast<std::size_t>(step));
  for (int first = 0; first < picture.rows; first += step) {
    const int count = std::min(step, picture.rows - first);
    for (int r = 0; r < count; ++r) fill(first + r, &buffer[cols * static_cast<std::size_t>(r)]);
    if (picture.type != GDT_Float32) {
      for (float& z : buffer) z = std::isnan(z) ? static_cast<float>(*picture.nodata) : z;
    }
    if (dataset.GetRasterBand(1)->RasterIO(GF_Write, 0, first, picture.cols, count, buffer.data(),
                                           picture.cols, count, GDT_Float32, 0, 0,
                                           nullptr) != CE_None) {
      return;  // Messages has heard why
    }
  }
}

void sync(const fs::path& path, const fs::path& file) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = fd >= 0 && ::fsync(fd) == 0;
  if (fd >= 0) ::close(fd);
  if (!synced) throw_io(file, "the disk did not take it");
}

void write(const fs::path& file, const Picture& picture, const FillRow& fill) {
  raise_fence();
  const Partial partial(file);
  const Messages messages;
  Dataset dataset = create(partial.path(), picture);
  if (!dataset) throw_io(file, messages.text("no reason given"));
  write_rows(*dataset, picture, fill);
  // Closing writes what is still cached, and may fail as any write; the closer hears nothing.
  GDALClose(GDALDataset::ToHandle(dataset.release()));
  if (messages.failed()) throw_io(file, messages.text({}));
  sync(partial.path(), file);
  partial.publish();
}

// The smallest type that keeps every height: integers only on the lattice of whole metres.
Picture choose_type(HeightSource& source) {
  Picture picture{.cols = source.cols(),
                  .rows = source.rows(),
                  .nodata = std::numeric_limits<double>::quiet_NaN()};
  const HeightLattice lattice = source.lattice();
  if (!lattice.integer || lattice.step_m != 1 || lattice.offset_m != std::floor(lattice.offset_m)) {
    return picture;
  }
  float low = 0, high = 0;
  std::vector<float> row(static_cast<std::size_t>(picture.cols));
  for (int r = 0; r < picture.rows; ++r) {
    source.read_row(r, row);
    for (const float z : row) {
      low = z < low ? z : low;
      high = z > high ? z : high;
    }
  }
  const bool short_enough = low > -32768 && high <= 32767;
  picture.type = short_enough ? GDT_Int16 : GDT_Int32;
  picture.nodata = short_enough ? -32768.0 : -2147483648.0;
  return picture;
}

}  // namespace

void write_geotiff(HeightSource& source, const fs::path& file) {
  Picture picture = choose_type(source);
  const Georef georef = source.georef();
  picture.georef = &georef;
  write(file, picture, [&](int r, float* out) {
    source.read_row(r, {out, static_cast<std::size_t>(picture.cols)});
  });
}

void write_geotiff(const fs::path& file, int width, int height, const float* values) {
  const Picture picture{.cols = width, .rows = height, .nodata = std::nullopt};
  const auto cols = static_cast<std::size_t>(width);
  write(file, picture, [&](int r, float* out) {
    const float* const row = values + cols * static_cast<std::size_t>(r);
    std::copy(row, row + cols, out);
  });
}

}  // namespace arete::raster
