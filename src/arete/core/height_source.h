#pragma once

#include <span>
#include <string>

#include "arete/core/georef.h"

namespace arete {

/// How the source stores its heights; decides the lattice that a store keeps them on.
struct HeightLattice {
  bool integer = false;  ///< every height is offset_m + step_m * integer
  double step_m = 0;     ///< metres; 0 when not integer
  double offset_m = 0;   ///< metres
};

/// Rows of heights, larger than memory perhaps. Single-threaded unless said otherwise.
class HeightSource {
 public:
  virtual ~HeightSource() = default;
  virtual int cols() const = 0;
  virtual int rows() const = 0;
  virtual Georef georef() const = 0;
  /// Heights of row r in metres, west to east (cols() values); NaN = no data. Row 0 is north.
  /// Cheapest when rows are read in ascending order. Throws: Io, Corrupt.
  virtual void read_row(int r, std::span<float> row) = 0;
  virtual HeightLattice lattice() const { return {}; }
  /// One line for people: file name(s), size, driver. No path beyond the file's own name.
  virtual std::string description() const { return "memory"; }
};

}  // namespace arete
