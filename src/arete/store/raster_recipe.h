#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "arete/core/georef.h"
#include "arete/core/raster_source.h"
#include "arete/store/height_patch.h"

namespace arete::store {

inline constexpr int kTexelTile = 256;

/// A pyramid of texels that follows from the heights, one level-0 texel a post. Level 0 is made
/// when it is read and not stored; each coarser level is the 2x2 mean of the one below.
struct RasterRecipe {
  std::string step;  ///< for progress
  RasterShape shape;
  int apron = 0;  ///< posts that level 0 needs around a tile
  /// Texels of posts [post.col, post.col + cols) of row post.row. Thread contract: any thread.
  std::function<void(const HeightPatch& patch, Post post, int cols, std::uint8_t* to)> make_texels;
  /// The mean of four neighbours.
  std::function<void(const std::array<const std::uint8_t*, 4>& from, std::uint8_t* to)> mean;
};

/// Normals as RG8 codes (core/normal_code.h) from central differences of the stored heights;
/// one-sided at the edge of what is stored.
RasterRecipe normals_recipe(const PyramidShape& shape, const Affine2& world_from_post,
                            double quantum_m);

/// Validity as R8: 255 where there is data, else 0.
RasterRecipe mask_recipe(const PyramidShape& shape);

/// The shape over a grid of texels; levels up to the first of one tile.
RasterShape pyramid_over(int width, int height);
int raster_tiles(int texels, int level, int tile_size);

/// A level-0 tile. Throws: what `read` throws.
void make_level0(const RasterRecipe& recipe, const PyramidShape& shape, TileId id,
                 const TileReader& read, Texels& texels);

}  // namespace arete::store
