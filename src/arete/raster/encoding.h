#pragma once

#include <cstddef>
#include <span>

#include "arete/core/height_source.h"
#include "arete/raster/dem.h"
#include "arete/raster/values.h"

namespace arete::raster {

/// Heights of RGB or RGBA bytes, `bands` of them a sample; alpha 0 is no data, and so are the
/// rule's nodata, compared in metres. Unit and exaggeration are the rule's step.
///   terrain-rgb: -10000 + 0.1 (65536 R + 256 G + B)     terrarium: 256 R + G + B / 256 - 32768
void decode_colours(Encoding encoding, int bands, const ValueRule& rule, const std::byte* samples,
                    std::span<float> out);

HeightLattice encoding_lattice(Encoding encoding, const ValueRule& rule);

}  // namespace arete::raster
