#pragma once

#include <memory>

#include "arete/core/height_source.h"
#include "arete/store/height_patch.h"
#include "arete/store/segment_reader.h"
#include "arete/store/terrain.h"

namespace arete::store {

/// Reads and decodes tiles of a heights segment. Throws: Corrupt, Io.
TileReader tiles_of(const SegmentReader& heights);

/// Stored heights by rows. Both arguments must outlive it.
std::unique_ptr<HeightSource> make_height_rows(const SegmentReader& heights,
                                               const Manifest& manifest);

}  // namespace arete::store
