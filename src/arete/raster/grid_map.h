#pragma once

#include <memory>
#include <span>
#include <string>

#include "arete/core/georef.h"

class OGRCoordinateTransformation;

namespace arete::raster {

/// A grid as far as its place goes: crs_from_post and the WKT of its CRS (empty = none).
struct GridPlace {
  Affine2 crs_from_post;
  std::string crs;
};

/// Finds positions of one grid in another, through their CRSs. Not thread-safe.
class GridMap {
 public:
  /// With a CRS missing on either side, or the same on both, coordinates are taken as common.
  /// `tolerance` in posts of `to`: how far map_row may be off. Throws: InvalidInput naming `name`
  /// when no transformation is known.
  GridMap(const GridPlace& from, const GridPlace& to, const std::string& name, double tolerance);
  ~GridMap();
  GridMap(const GridMap&) = delete;
  GridMap& operator=(const GridMap&) = delete;

  /// Columns and rows in `to` of the positions (first_col + i col_step, row) in `from`;
  /// NaN where the transformation has no image. Requires: equal sizes.
  void map_row(double first_col, double col_step, double row, std::span<double> cols,
               std::span<double> rows) const;

 private:
  static int transform(void* self, int to_from, int count, double* x, double* y, double* z,
                       int* success);
  Affine2 from_, to_;
  std::unique_ptr<OGRCoordinateTransformation> crs_;  ///< null: the coordinates are common
  void* approximate_ = nullptr;
};

}  // namespace arete::raster
