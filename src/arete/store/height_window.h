#pragma once

#include <cstdint>
#include <vector>

#include "arete/store/height_band.h"

namespace arete::store {

/// Whole level-0 rows [first, first + rows) of the grid, with one absent post at either end of a
/// row; rows outside the grid are absent.
class HeightWindow {
 public:
  /// Throws: what `read` throws.
  void load(const PyramidShape& shape, int first, int rows, const TileReader& read);
  /// Post 0 of row first + r; posts -1 and cols may be read.
  const std::int32_t* row(int r) const { return counts_.data() + index(r) + 1; }
  const std::uint8_t* valid_row(int r) const { return valid_.data() + index(r) + 1; }
  /// Bytes that a window over `rows` rows needs, its band included.
  static std::size_t bytes(int cols, int rows);

 private:
  std::size_t index(int r) const { return static_cast<std::size_t>(r) * stride_; }
  std::size_t stride_ = 0;
  std::vector<std::int32_t> counts_;
  std::vector<std::uint8_t> valid_;
  HeightBand band_;
};

}  // namespace arete::store
