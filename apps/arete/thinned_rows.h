#pragma once

#include <vector>

#include "arete/core/height_source.h"

namespace arete::app {

/// Every step-th row and column of a source, from the north-west corner: the same land with its
/// posts further apart, by plain row reads. `full` must outlive it.
class ThinnedRows : public HeightSource {
 public:
  /// Requires: step >= 1.
  ThinnedRows(HeightSource& full, int step);
  int cols() const override;
  int rows() const override;
  Georef georef() const override;
  void read_row(int r, std::span<float> row) override;
  HeightLattice lattice() const override { return full_.lattice(); }
  std::string description() const override { return full_.description(); }

 private:
  HeightSource& full_;
  int step_;
  std::vector<float> row_;
};

}  // namespace arete::app
