#pragma once

#include <cstdint>
#include <vector>

#include "arete/core/tile_id.h"

namespace arete {

/// One square of texels, row-major, north first, `channels` bytes a texel.
struct Texels {
  int size = 0;      ///< texels a side
  int channels = 0;  ///< 1 to 4
  std::vector<std::uint8_t> bytes;
};

/// What a renderer must know of a pyramid. Texel (i, j) of level l covers level-0 texels
/// [i 2^l, (i+1) 2^l); level-0 texel (i, j) is centred on post (i, j) / 2^texels_per_post_log2.
struct RasterShape {
  int width = 0, height = 0;  ///< level-0 texels
  int levels = 0;             ///< the coarsest level is one tile
  int tile_size = 256;        ///< texels a side
  int channels = 1;
  int texels_per_post_log2 = 0;  ///< > 0 for a drape finer than the DEM
  std::uint8_t fill = 0;         ///< every byte of an absent tile
};

/// A pyramid of texels: normals (RG8), validity (R8), drape (RGB8), light (R8).
/// Thread contract: safe from several threads at once.
class RasterSource {
 public:
  virtual ~RasterSource() = default;
  virtual RasterShape shape() const = 0;
  /// The tile; all `fill` where nothing is stored or the block is damaged. Throws: nothing.
  virtual Texels read(TileId id) const = 0;
};

}  // namespace arete
