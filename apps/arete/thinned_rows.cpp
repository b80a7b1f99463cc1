#include "thinned_rows.h"

#include <cassert>

namespace arete::app {
namespace {

Affine2 spread(Affine2 affine, int step) {
  for (const std::size_t i : {0U, 1U, 3U, 4U}) {
    affine.m[i] *= step;
  }
  return affine;
}

}  // namespace

ThinnedRows::ThinnedRows(HeightSource& full, int step)
    : full_(full), step_(step), row_(static_cast<std::size_t>(full.cols())) {
  assert(step >= 1);
}

int ThinnedRows::cols() const {
  return (full_.cols() - 1) / step_ + 1;
}

int ThinnedRows::rows() const {
  return (full_.rows() - 1) / step_ + 1;
}

Georef ThinnedRows::georef() const {
  Georef georef = full_.georef();
  georef.world_from_post = spread(georef.world_from_post, step_);
  georef.crs_from_post = spread(georef.crs_from_post, step_);
  return georef;
}

void ThinnedRows::read_row(int r, std::span<float> row) {
  full_.read_row(r * step_, row_);
  for (std::size_t c = 0; c < row.size(); ++c) {
    row[c] = row_[c * static_cast<std::size_t>(step_)];
  }
}

}  // namespace arete::app
