#pragma once

#include "arete/core/build_context.h"
#include "arete/store/raster_recipe.h"
#include "arete/store/unit.h"

namespace arete::store {

/// Makes the levels 1 and up of a pyramid, a unit a row of tiles in the order of their keys;
/// tiles of nothing but `fill` are left out. Returns the number of units.
int make_raster_units(const RasterRecipe& recipe, const PyramidShape& shape,
                      const TileReader& heights, const UnitFolder& units,
                      const BuildContext& context);

/// All texels are `fill`.
bool is_fill(const RasterShape& shape, const Texels& texels);

}  // namespace arete::store
