#pragma once

#include "arete/store/fill_grid.h"
#include "arete/store/height_patch.h"
#include "arete/store/unit.h"

namespace arete::store {

/// Memory that store_level_row needs, about.
inline constexpr std::size_t kLevelRowBytes = std::size_t{8} << 20U;

/// Stores tile row `id.y` of level `id.level` >= 1, subsampled from the level below, which `finer`
/// reads; tiles without valid posts are left out. Posts that no finer tile holds are invalid and
/// get the grid's height; `grid` may be null when there are none.
void store_level_row(const PyramidShape& shape, TileId id, const TileReader& finer,
                     const FillGrid* grid, UnitWriter& unit);

}  // namespace arete::store
