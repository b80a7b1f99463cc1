#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "arete/store/pyramid_shape.h"
#include "arete/store/terrain.h"

namespace arete::store {

/// The count of a post that lies in no stored tile; no real count takes this value.
inline constexpr std::int32_t kAbsent = std::numeric_limits<std::int32_t>::min();

/// Fills `tile`; false when it is not stored. Called from several threads at once.
using TileReader = std::function<bool(TileId, HeightTile&)>;

/// The full-width row y of tiles of one level: kTilePosts rows of width() posts, row-major.
struct HeightBand {
  int width = 0;                     ///< posts a row: tiles * kTileCells + 1
  std::vector<std::int32_t> counts;  ///< kAbsent where nothing is stored
  std::vector<std::uint8_t> valid;   ///< 1 = data
  std::vector<std::uint8_t> stored;  ///< a flag a tile of the row

  const std::int32_t* row(int r) const { return counts.data() + index(r, 0); }
  const std::uint8_t* valid_row(int r) const { return valid.data() + index(r, 0); }
  std::size_t index(int r, int c) const {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(c);
  }
};

/// Reads a row of tiles. A border post shared with a stored tile of a neighbouring row is taken
/// from there when its own tile is absent. Throws: what `read` throws.
void load_band(const PyramidShape& shape, TileId first, const TileReader& read, HeightBand& band);

}  // namespace arete::store
