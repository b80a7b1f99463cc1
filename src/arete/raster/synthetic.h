#pragma once

#include <cstdint>
#include <memory>

#include "arete/core/height_source.h"

namespace arete::raster {

enum class SyntheticKind { Fbm, Ridged, Terraces, Flat, Slope };

/// A seeded terrain of size x size posts, 30 m apart; any row on its own, no memory of the grid.
std::unique_ptr<HeightSource> synthesize(SyntheticKind kind, int size, std::uint64_t seed);

}  // namespace arete::raster
