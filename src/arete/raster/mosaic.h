#pragma once

#include <memory>
#include <vector>

#include "arete/core/height_source.h"
#include "arete/raster/dem_file.h"

namespace arete::raster {

/// One grid of several files that share CRS, spacing (within 1e-6 of it) and alignment (within
/// 1e-3 post). Where files overlap the first valid one wins; how many posts of the rows read so
/// far differ, and by how much at most, is a note of georef(). Files that one row crosses share
/// `buffer_bytes`. Throws: InvalidInput, Limit.
std::unique_ptr<HeightSource> make_mosaic(std::vector<std::unique_ptr<DemFile>> files, int max_side,
                                          std::size_t buffer_bytes);

}  // namespace arete::raster
