#include "arete/store/raster_recipe.h"

#include <algorithm>

namespace arete::store {

RasterShape pyramid_over(int width, int height) {
  RasterShape shape;
  shape.width = width;
  shape.height = height;
  shape.tile_size = kTexelTile;
  shape.levels = 1;
  while (raster_tiles(width, shape.levels - 1, kTexelTile) > 1 ||
         raster_tiles(height, shape.levels - 1, kTexelTile) > 1)
    ++shape.levels;
  return shape;
}

int raster_tiles(int texels, int level, int tile_size) {
  const int at_level = (texels + (1 << level) - 1) >> level;
  return (at_level + tile_size - 1) / tile_size;
}

void make_level0(const RasterRecipe& recipe, const PyramidShape& shape, TileId id,
                 const TileReader& read, Texels& texels) {
  thread_local HeightPatch patch;
  const Post corner{static_cast<int>(id.x) * kTexelTile, static_cast<int>(id.y) * kTexelTile};
  const int cols = std::min(kTexelTile, shape.cols - corner.col);
  const int rows = std::min(kTexelTile, shape.rows - corner.row);
  if (cols <= 0 || rows <= 0) return;
  patch.load(shape, 0,
             {corner.col - recipe.apron, corner.row - recipe.apron,
              corner.col + cols + recipe.apron, corner.row + rows + recipe.apron},
             BeyondGrid::Drop, read);
  for (int r = 0; r < rows; ++r)
    recipe.make_texels(patch, {corner.col, corner.row + r}, cols,
                       &texels.bytes[static_cast<std::size_t>(r * kTexelTile) *
                                     static_cast<std::size_t>(recipe.shape.channels)]);
}

}  // namespace arete::store
