#include "arete/raster/why_unreadable.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include <fmt/format.h>

namespace arete::raster {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 2> kSide = {".hdr", ".prj"};
constexpr std::array<std::string_view, 5> kNeedHeader = {".bil", ".bip", ".bsq", ".flt", ".raw"};
constexpr std::array<std::string_view, 3> kMayHaveLabel = {".img", ".dat", ".cub"};

std::string lower_extension(const fs::path& file) {
  std::string text = file.extension().string();
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_beside(const fs::path& file, const char* extension) {
  std::error_code ignored;
  return fs::exists(fs::path(file).replace_extension(extension), ignored);
}

template <std::size_t n>
bool is_one_of(const std::array<std::string_view, n>& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

}  // namespace

std::string why_unreadable(const fs::path& file, const std::string& gdal_says) {
  const std::string extension = lower_extension(file);
  if (is_one_of(kSide, extension)) return "a side file: name the data file beside it";
  if (gdal_says.find("No such file") != gdal_says.npos) {
    return fmt::format("the file of its samples is missing ({}): put it beside this one",
                       gdal_says);
  }
  if (!gdal_says.empty()) {
    return fmt::format("not readable ({}): convert it to GeoTIFF, or fetch it again if it is one",
                       gdal_says);
  }
  if (is_one_of(kNeedHeader, extension) && !is_beside(file, ".hdr") && !is_beside(file, ".HDR")) {
    return fmt::format("its header is missing: put {}.hdr beside it", file.stem().string());
  }
  if (is_one_of(kMayHaveLabel, extension)) {
    return "not readable on its own: name its label (.lbl, .xml) if it has one, or convert it to "
           "GeoTIFF";
  }
  return "no DEM format that is read: convert it to GeoTIFF (gdal_translate)";
}

}  // namespace arete::raster
