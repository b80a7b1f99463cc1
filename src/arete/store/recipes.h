#pragma once

#include "arete/core/georef.h"
#include "arete/store/height_band.h"
#include "arete/store/raster_build.h"

namespace arete::store {

/// Normals as RG8 codes (core/normal_code.h), one texel a post, from central differences of the
/// stored heights; one-sided at the edge of what is stored. `read` must outlive the recipe.
RasterRecipe normals_recipe(const PyramidShape& shape, const Affine2& world_from_post,
                            double quantum_m, const TileReader& read);

/// Validity as R8, one texel a post: 255 where there is data, else 0; coarser levels are means.
RasterRecipe mask_recipe(const PyramidShape& shape, const TileReader& read);

}  // namespace arete::store
