#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "arete/store/fill_grid.h"
#include "arete/store/lattice.h"
#include "arete/store/pyramid_shape.h"
#include "arete/store/unit.h"

namespace arete::store {

/// The grid's rows under one row of level-0 tiles, as counts.
struct SourceBand {
  int y = 0;                         ///< row of tiles
  int rows = 0;                      ///< rows of the grid that are filled: at most kTilePosts
  std::vector<std::int32_t> counts;  ///< kTilePosts rows of `cols` posts; kAbsent = no data
  RowStats stats;                    ///< of the rows that the band owns
};

/// What is known of a band once its tiles are stored. A band owns its rows but the last, which
/// the next band owns; the last band owns all its rows.
struct BandSummary {
  RowStats stats;
  std::uint64_t drawable_cells = 0;
  std::uint8_t has_holes = 0;              ///< some post of the band, border included, has no data
  std::vector<FillGrid::Cell> fill_cells;  ///< the rows of the fill grid under the band

  std::vector<std::byte> to_bytes() const;
  static BandSummary from_bytes(std::span<const std::byte> bytes);
};

/// First grid row and number of rows that the band owns.
int owned_rows(const PyramidShape& shape, int y);

/// Stores the tiles of a band that have a drawable cell; invalid posts get some value, which
/// fill_band replaces. The summary goes into the unit's aux.
void store_band(const PyramidShape& shape, int fill_cell_posts, const SourceBand& band,
                UnitWriter& unit);

/// Copies a stored band, each post without data getting its height from the grid.
void fill_band(const PyramidShape& shape, const FillGrid& grid, const UnitReader& from,
               UnitWriter& to);

}  // namespace arete::store
