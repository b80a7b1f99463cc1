#include "arete/raster/fence.h"

#include <algorithm>
#include <array>
#include <mutex>
#include <regex>
#include <string_view>

#include <cpl_conv.h>
#include <cpl_string.h>
#include <fmt/format.h>
#include <gdal_frmts.h>
#include <ogr_srs_api.h>

#include "arete/core/error.h"
#include "arete/raster/container.h"
#include "arete/raster/hdf5_check.h"
#include "arete/raster/why_unreadable.h"

namespace arete::raster {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMaxBlockBytes = std::int64_t{64} << 20;

constexpr std::array kDemDrivers = {
    "GTiff", "SRTMHGT", "DTED",  "USGSDEM", "AAIGrid", "HFA",      "PNG",   "PNM",  "netCDF", "GTX",
    "GSAG",  "GSBG",    "GS7BG", "PDS",     "PDS4",    "Terragen", "ISIS3", "EHdr", "ENVI"};
constexpr std::array kPictureDrivers = {"GTiff", "PNG", "JPEG", "HFA", "PNM", "ENVI", "EHdr"};

// GDAL asks the drivers in this order. Last come those that a header beside the file is enough for:
// before the others they would take any picture with one for raw samples.
void register_drivers() {
  GDALRegister_GTiff();
  GDALRegister_SRTMHGT();
  GDALRegister_DTED();
  GDALRegister_USGSDEM();
  GDALRegister_AAIGrid();
  GDALRegister_HFA();
  GDALRegister_PNG();
  GDALRegister_JPEG();
  GDALRegister_PNM();
  GDALRegister_netCDF();
  GDALRegister_GTX();
  GDALRegister_GSAG();
  GDALRegister_GSBG();
  GDALRegister_GS7BG();
  GDALRegister_Terragen();
  GDALRegister_PDS();
  GDALRegister_PDS4();
  GDALRegister_ISIS3();
  GDALRegister_EHdr();
  GDALRegister_ENVI();
}

// Set explicitly, because an environment variable of the same name would count otherwise.
void set_options() {
  CPLSetConfigOption("GDAL_PAM_ENABLED", "NO");
  CPLSetConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", "EMPTY_DIR");
  CPLSetConfigOption("CPL_VSIL_CURL_ALLOWED_EXTENSIONS", ".none");
  CPLSetConfigOption("CPL_DEBUG", "OFF");
  CPLSetConfigOption("GTIFF_POINT_GEO_IGNORE", "NO");
  CPLSetConfigOption("GDAL_CACHEMAX", "128");   // MiB, until limit_block_cache
  CPLSetConfigOption("GDAL_NUM_THREADS", "2");  // GTiff's decoding and encoding
  OSRSetPROJEnableNetwork(0);
}

// GDAL names whole paths; messages keep to the file's own name. A path begins at a '/' that no
// name stands before, and its last '/' ends what is dropped.
std::string without_folders(const std::string& text) {
  static const std::regex folders("(^|[\\s:'\"(])/(?:[^\\s:'\"(]*/)*");
  return std::regex_replace(text, folders, "$1");
}

CPLStringList driver_list(Purpose purpose) {
  CPLStringList list;
  const auto add = [&](const auto& names) {
    for (const char* name : names) list.AddString(name);
  };
  if (purpose == Purpose::Dem) {
    add(kDemDrivers);
  } else {
    add(kPictureDrivers);
  }
  return list;
}

// The side files that EHdr, ENVI and AAIGrid cannot do without; nothing else of the folder, or of
// the archive, is shown to GDAL.
CPLStringList siblings(const fs::path& file) {
  CPLStringList list;
  list.AddString(file.filename().c_str());
  for (const char* extension : {".hdr", ".HDR", ".prj", ".PRJ"}) {
    fs::path beside = file;
    beside.replace_extension(extension);
    VSIStatBufL status;
    if (beside != file && VSIStatL(beside.c_str(), &status) == 0 && VSI_ISREG(status.st_mode)) {
      list.AddString(beside.filename().c_str());
    }
  }
  return list;
}

void check_name(const fs::path& file) {
  const std::string& text = file.native();
  if (text.starts_with("/vsi") || text.starts_with('<') || text.find("://") != text.npos) {
    throw Error(ErrorCode::Unsupported,
                fmt::format("{}: not a local file: copy it to a disk and name that copy", text));
  }
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) {
    throw Error(ErrorCode::NotFound, fmt::format("{}: no such file: check the path", text));
  }
  if (!fs::is_regular_file(status)) {
    throw Error(ErrorCode::InvalidInput,
                fmt::format("{}: not a regular file: name the DEM file itself", text));
  }
}

Dataset open_with(const std::string& name, Purpose purpose, CSLConstList beside) {
  const CPLStringList drivers = driver_list(purpose);
  return Dataset(GDALDataset::Open(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers.List(),
                                   nullptr, beside));
}

// Labels of the planetary drivers may name another file for the samples: only a twin in the same
// folder is let through.
void check_references(GDALDataset& dataset, const fs::path& file) {
  const std::string_view driver = dataset.GetDriverName();
  if (driver != "PDS" && driver != "PDS4" && driver != "ISIS3") return;
  const CPLStringList files(dataset.GetFileList());
  for (int i = 0; i < files.Count(); ++i) {
    const fs::path other = fs::path(files[i]).lexically_normal();
    if (other.parent_path() != file.parent_path().lexically_normal() ||
        other.stem() != file.stem()) {
      throw Error(ErrorCode::Unsupported,
                  fmt::format("{}: its label refers to another file: convert it to GeoTIFF first",
                              display_name(file)));
    }
  }
}

}  // namespace

void DatasetCloser::operator()(GDALDataset* dataset) const {
  const Messages unheard;
  GDALClose(GDALDataset::ToHandle(dataset));
}

void raise_fence() {
  static std::once_flag once;
  std::call_once(once, [] {
    // Also hears what GDAL's own threads say; Messages hears its thread's.
    CPLSetErrorHandler(CPLQuietErrorHandler);
    set_options();
    register_drivers();
  });
}

void limit_block_cache(std::size_t memory_limit) {
  constexpr std::size_t kLeast = std::size_t{16} << 20U, kMost = std::size_t{128} << 20U;
  GDALSetCacheMax64(static_cast<GIntBig>(std::clamp(memory_limit / 8, kLeast, kMost)));
}

Messages::Messages() {
  CPLPushErrorHandlerEx(hear, this);
}

Messages::~Messages() {
  CPLPopErrorHandler();
}

void Messages::hear(CPLErr level, CPLErrorNum, const char* text) {
  auto* self = static_cast<Messages*>(CPLGetErrorHandlerUserData());
  std::string line = text;
  std::replace(line.begin(), line.end(), '\n', ' ');
  if (level == CE_Warning) {
    self->warning_ = std::move(line);
  } else if (level >= CE_Failure && self->failure_.empty()) {
    self->failure_ = std::move(line);
  }
}

std::string Messages::text(const std::string& otherwise) const {
  if (!failure_.empty()) return without_folders(failure_);
  return warning_.empty() ? otherwise : without_folders(warning_);
}

std::string display_name(const fs::path& file) {
  return file.filename().string();
}

namespace {

[[noreturn]] void throw_unreadable(const fs::path& path, const Messages& messages) {
  throw Error(ErrorCode::Unsupported,
              fmt::format("{}: {}", display_name(path), why_unreadable(path, messages.text({}))));
}

}  // namespace

Dataset open_fenced(const fs::path& file, Purpose purpose, std::string* note) {
  raise_fence();
  check_name(file);
  const fs::path path = fs::absolute(file);
  const Messages messages;
  std::string name = path.native();
  if (is_zip(path)) name = zip_member(path);
  const CPLStringList beside = siblings(name);
  check_hdf5(path);
  Dataset dataset = open_with(name, purpose, beside.List());
  if (!dataset || path.extension() == ".prj") throw_unreadable(path, messages);
  check_references(*dataset, path);
  if (dataset->GetRasterCount() == 0) {
    const std::string variable = largest_variable(*dataset, name, note);
    if (!variable.empty()) dataset = open_with(variable, purpose, nullptr);
  }
  if (!dataset || dataset->GetRasterCount() == 0) {
    throw Error(ErrorCode::InvalidInput,
                fmt::format("{}: holds no grid of samples: convert one of its layers to GeoTIFF",
                            display_name(file)));
  }
  return dataset;
}

namespace {

void check_blocks(GDALRasterBand& band, const std::string& name) {
  int width = 0, height = 0;
  band.GetBlockSize(&width, &height);
  const std::int64_t bytes =
      std::int64_t{width} * height * GDALGetDataTypeSizeBytes(band.GetRasterDataType());
  if (width >= 1 && height >= 1 && bytes <= kMaxBlockBytes) return;
  throw Error(ErrorCode::Limit,
              fmt::format("{}: stored in blocks of {} x {} samples, over 64 MiB: rewrite it tiled "
                          "(gdal_translate -co TILED=YES)",
                          name, width, height));
}

}  // namespace

void check_shape(GDALDataset& dataset, int max_side, const std::string& name) {
  const int cols = dataset.GetRasterXSize();
  const int rows = dataset.GetRasterYSize();
  if (cols < 1 || rows < 1 || cols > max_side || rows > max_side) {
    throw Error(ErrorCode::Limit,
                fmt::format("{}: {} x {} samples, over {} a side: cut it into parts", name, cols,
                            rows, max_side));
  }
  for (int i = 1; i <= dataset.GetRasterCount(); ++i) {
    check_blocks(*dataset.GetRasterBand(i), name);
    if (GDALRasterBand* const mask = file_mask(dataset, i)) check_blocks(*mask, name);
  }
}

GDALRasterBand* file_mask(GDALDataset& dataset, int band) {
  // Of other drivers GDAL may look for a mask in a file beside, which any driver reads.
  if (std::string_view(dataset.GetDriverName()) != "GTiff") return nullptr;
  const bool own = (dataset.GetRasterBand(band)->GetMaskFlags() & GMF_PER_DATASET) != 0;
  return own ? dataset.GetRasterBand(band)->GetMaskBand() : nullptr;
}

}  // namespace arete::raster
