#pragma once

#include <filesystem>

namespace arete::raster {

/// HDF5, which netCDF-4 is written in, may keep a variable's samples in any other file of the disk
/// (external storage, virtual datasets, external links), and the netCDF driver follows: refuses
/// such files, and BAGs, whose south-up grids lie where only metadata say that it does not read.
/// Files that are not HDF5 pass. Throws: Unsupported, InvalidInput. Not thread-safe.
void check_hdf5(const std::filesystem::path& file);

}  // namespace arete::raster
