#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "arete/raster/fence.h"
#include "arete/raster/grid_map.h"

namespace arete::raster {

/// A colour picture in memory, row-major, top row first.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  ///< width x height x 3
};

/// A picture that is open but not read.
struct PictureFile {
  std::string name;
  std::filesystem::path path;
  Dataset dataset;
  GridPlace place;  ///< of its pixel centres; crs empty when it does not say
  int width = 0, height = 0;
  bool geographic = false;
};

/// Throws: as open_dem.
PictureFile open_picture(const std::filesystem::path& file);

/// Reads it with every 2^shrink x 2^shrink pixels averaged (the last ones of a side may be fewer).
/// Grey, palette, RGB(A) and multi-band pictures of 8 or 16 bits; the dataset is closed. Throws:
/// Unsupported, Corrupt.
Picture read_picture(PictureFile& file, int shrink);

}  // namespace arete::raster
