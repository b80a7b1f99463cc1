#pragma once

#include "arete/core/raster_source.h"
#include "arete/store/store_builder.h"

namespace arete::store {

/// Copies a pyramid into the segment "drape", tile by tile, leaving out tiles of nothing but fill.
void write_drape(const RasterSource& drape, StoreBuilder& builder);

}  // namespace arete::store
