#include "arete/store/height_window.h"

#include <algorithm>

namespace arete::store {

void HeightWindow::load(const PyramidShape& shape, int first, int rows, const TileReader& read) {
  stride_ = static_cast<std::size_t>(shape.cols) + 2;
  counts_.assign(static_cast<std::size_t>(rows) * stride_, kAbsent);
  valid_.assign(static_cast<std::size_t>(rows) * stride_, 0);
  int loaded = -1;
  for (int r = std::max(0, -first); r < rows && first + r < shape.rows; ++r) {
    const int y = std::min((first + r) / kTileCells, shape.tiles_y(0) - 1);
    if (y != loaded) load_band(shape, {0, 0, static_cast<std::uint32_t>(y)}, read, band_);
    loaded = y;
    const int from = first + r - y * kTileCells;
    const auto to = static_cast<std::ptrdiff_t>(index(r) + 1);
    std::copy_n(band_.row(from), shape.cols, counts_.begin() + to);
    std::copy_n(band_.valid_row(from), shape.cols, valid_.begin() + to);
  }
}

std::size_t HeightWindow::bytes(int cols, int rows) {
  return static_cast<std::size_t>(cols + kTilePosts) * static_cast<std::size_t>(rows + kTilePosts) *
         (sizeof(std::int32_t) + 1);
}

}  // namespace arete::store
