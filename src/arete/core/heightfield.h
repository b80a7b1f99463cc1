#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "arete/core/height_source.h"

namespace arete {

/// A whole grid in memory: rows x cols posts, row-major, north first, metres, NaN = no data.
class Heightfield : public HeightSource {
 public:
  Heightfield() = default;
  Heightfield(int cols, int rows, Georef georef = {});
  /// Reads every row of the source. Throws: what the source throws.
  explicit Heightfield(HeightSource& source);

  int cols() const override { return cols_; }
  int rows() const override { return rows_; }
  Georef georef() const override { return georef_; }
  HeightLattice lattice() const override { return lattice_; }
  void read_row(int r, std::span<float> row) override;
  void set_lattice(HeightLattice lattice) { lattice_ = lattice; }

  float operator[](Post p) const { return z_[index(p)]; }
  float& operator[](Post p) { return z_[index(p)]; }
  std::span<const float> row(int r) const;
  std::span<const float> posts() const { return z_; }

  bool valid(Post p) const { return !std::isnan(z_[index(p)]); }
  /// A cell is drawable when its four posts are valid. Requires: a cell of the grid.
  bool drawable(Post cell) const;

 private:
  std::size_t index(Post p) const {
    return static_cast<std::size_t>(p.row) * static_cast<std::size_t>(cols_) +
           static_cast<std::size_t>(p.col);
  }
  int cols_ = 0, rows_ = 0;
  Georef georef_;
  HeightLattice lattice_;
  std::vector<float> z_;
};

}  // namespace arete
