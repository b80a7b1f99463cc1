#pragma once

#include <filesystem>
#include <string>

class GDALDataset;

namespace arete::raster {

/// True for names that end in .zip, in any case.
bool is_zip(const std::filesystem::path& file);

/// GDAL's name of the one raster member of an archive. Throws: InvalidInput (none, several or an
/// unsafe name), Limit (too many members, or one that unpacks to over 16 GiB).
std::string zip_member(const std::filesystem::path& archive);

/// GDAL's name of the largest two-dimensional variable that the dataset offers, the first among
/// equals; empty when there is none. Says in *note which it took.
std::string largest_variable(GDALDataset& dataset, const std::string& name, std::string* note);

}  // namespace arete::raster
