#include "arete/raster/container.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <string_view>
#include <vector>

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal_priv.h>

#include "arete/core/error.h"

namespace arete::raster {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxMembers = 1000;
constexpr std::int64_t kMaxMemberBytes = std::int64_t{16} << 30;
// Not netCDF, whose samples HDF5 may take from other files (hdf5_check.h).
constexpr std::array kRasterExtensions = {".tif", ".tiff", ".hgt", ".dt0", ".dt1", ".dt2",
                                          ".dem", ".asc",  ".flt", ".bil", ".img", ".png",
                                          ".grd", ".gtx",  ".ter", ".jpg", ".jpeg"};

std::string lower_extension(const fs::path& file) {
  std::string text = file.extension().string();
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_raster_name(const fs::path& member) {
  const std::string extension = lower_extension(member);
  return std::find(kRasterExtensions.begin(), kRasterExtensions.end(), extension) !=
         kRasterExtensions.end();
}

bool is_plain(std::string_view member) {
  return !member.starts_with('/') && member.find("..") == member.npos &&
         member.find("/vsi") == member.npos && member.find(':') == member.npos;
}

// "[1201x2401] data (32-bit floating-point)": the product of the sides if there are two, else 0.
std::int64_t area(const char* description) {
  int rows = 0, cols = 0;
  char end = 0;
  if (std::sscanf(description, "[%dx%d%c", &rows, &cols, &end) != 3 || end != ']') return 0;
  return std::int64_t{rows} * cols;
}

}  // namespace

bool is_zip(const fs::path& file) {
  return lower_extension(file) == ".zip";
}

std::string zip_member(const fs::path& archive) {
  const std::string name = archive.filename().string();
  const std::string root = "/vsizip/" + archive.native();
  const CPLStringList members(VSIReadDirRecursive(root.c_str()));
  if (members.Count() > kMaxMembers) {
    throw Error(ErrorCode::Limit,
                fmt::format("{}: over {} members: unpack it first", name, kMaxMembers));
  }
  std::vector<std::string> found;
  for (int i = 0; i < members.Count(); ++i) {
    if (is_raster_name(members[i]) && is_plain(members[i])) found.emplace_back(members[i]);
  }
  if (found.size() != 1) {
    throw Error(ErrorCode::InvalidInput,
                fmt::format("{}: {} DEM files inside, not one: unpack it and name the files", name,
                            found.size()));
  }
  std::string member = root + "/" + found.front();
  VSIStatBufL status;
  if (VSIStatL(member.c_str(), &status) != 0 || status.st_size > kMaxMemberBytes) {
    throw Error(ErrorCode::Limit,
                fmt::format("{}: its member is over 16 GiB or unreadable: unpack it first", name));
  }
  return member;
}

std::string largest_variable(GDALDataset& dataset, const std::string& name, std::string* note) {
  if (std::string_view(dataset.GetDriverName()) != "netCDF") return {};
  if (name.find('"') != name.npos) return {};
  char** list = dataset.GetMetadata("SUBDATASETS");
  std::int64_t best = 0;
  std::string variable;
  for (int i = 1;; ++i) {
    const char* full = CSLFetchNameValue(list, fmt::format("SUBDATASET_{}_NAME", i).c_str());
    const char* text = CSLFetchNameValue(list, fmt::format("SUBDATASET_{}_DESC", i).c_str());
    if (full == nullptr || text == nullptr) break;
    const std::string_view view = full;
    const std::string candidate(view.substr(view.rfind(':') + 1));
    if (area(text) > best && candidate.find('"') == candidate.npos) {
      best = area(text);
      variable = candidate;
    }
  }
  if (variable.empty()) return {};
  if (note != nullptr) *note = fmt::format("Variable '{}' was read, the largest grid.", variable);
  return fmt::format("NETCDF:\"{}\":{}", name, variable);
}

}  // namespace arete::raster
