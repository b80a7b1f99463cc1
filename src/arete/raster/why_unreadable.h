#pragma once

#include <filesystem>
#include <string>

namespace arete::raster {

/// "what: what to do" about a file that no driver opened; `gdal_says` may be empty.
std::string why_unreadable(const std::filesystem::path& file, const std::string& gdal_says);

}  // namespace arete::raster
