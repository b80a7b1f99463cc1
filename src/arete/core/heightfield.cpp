#include "arete/core/heightfield.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace arete {

Heightfield::Heightfield(int cols, int rows, Georef georef)
    : cols_(cols),
      rows_(rows),
      georef_(std::move(georef)),
      z_(static_cast<std::size_t>(cols) * static_cast<std::size_t>(rows)) {}

Heightfield::Heightfield(HeightSource& source)
    : Heightfield(source.cols(), source.rows(), source.georef()) {
  lattice_ = source.lattice();
  for (int r = 0; r < rows_; ++r) {
    source.read_row(r, std::span(z_).subspan(index({0, r}), static_cast<std::size_t>(cols_)));
  }
}

void Heightfield::read_row(int r, std::span<float> out) {
  assert(out.size() == static_cast<std::size_t>(cols_));
  std::ranges::copy(row(r), out.begin());
}

std::span<const float> Heightfield::row(int r) const {
  return std::span(z_).subspan(index({0, r}), static_cast<std::size_t>(cols_));
}

bool Heightfield::drawable(Post c) const {
  return valid(c) && valid({c.col + 1, c.row}) && valid({c.col, c.row + 1}) &&
         valid({c.col + 1, c.row + 1});
}

}  // namespace arete
