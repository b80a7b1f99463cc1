#pragma once

#include <filesystem>

namespace arete::raster {

/// HDF5, which netCDF-4 is written in, may keep a variable's samples in any other file of the disk
/// (external storage, virtual datasets, external links), and the netCDF driver follows: refuses
/// such files. Others pass unread. Throws: Unsupported, InvalidInput. Not thread-safe.
void refuse_external_storage(const std::filesystem::path& file);

}  // namespace arete::raster
