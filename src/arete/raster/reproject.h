#pragma once

#include <memory>
#include <string>

#include "arete/core/height_source.h"
#include "arete/raster/dem.h"

namespace arete::raster {

/// The source on a north-up grid of options.crs, square posts about as dense as its own,
/// bilinear; a post is valid where the nearest of the source is. The source itself when it is in
/// that CRS already. `name` is for messages. Memory: of options.memory_limit an eighth for rows of
/// the source and a sixteenth for rows of the result, or two rows and one. Throws: InvalidInput,
/// Limit.
std::unique_ptr<HeightSource> reproject(std::unique_ptr<HeightSource> source,
                                        const std::string& name, const DemOptions& options);

}  // namespace arete::raster
