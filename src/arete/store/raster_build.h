#pragma once

#include <array>
#include <functional>
#include <string>

#include "arete/core/raster_source.h"
#include "arete/store/pyramid_shape.h"
#include "arete/store/unit.h"

namespace arete::store {

inline constexpr int kTexelTile = 256;

/// How a pyramid of texels is made: level 0 by rows of tiles, each coarser level from the finer.
struct RasterRecipe {
  std::string step;  ///< for progress
  RasterShape shape;
  std::size_t bytes_each = 0;  ///< memory that one call of make_row needs
  /// Calls keep(x, texels) for tiles of level-0 row y that are not all `fill`, x ascending. Texels
  /// beyond the shape may hold anything. Called from several threads at once.
  std::function<void(int y, const std::function<void(int x, Texels& texels)>& keep)> make_row;
  /// Texel bytes of the mean of four neighbours.
  std::function<void(const std::array<const std::uint8_t*, 4>& from, std::uint8_t* to)> mean;
};

/// The pyramid's shape over a grid of texels; levels up to the first of one tile.
RasterShape pyramid_over(int width, int height);
int raster_tiles(int texels, int level, int tile_size);

/// Makes all rows of tiles of all levels as units, in the order of their keys. Returns their
/// number.
int make_raster_units(const RasterRecipe& recipe, const UnitFolder& units,
                      const BuildContext& context);

}  // namespace arete::store
