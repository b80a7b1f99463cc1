#include "arete/raster/grid_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <fmt/format.h>
#include <gdal_alg.h>
#include <ogr_spatialref.h>

#include "arete/core/error.h"
#include "arete/raster/fence.h"
#include "arete/raster/placement.h"

namespace arete::raster {
namespace {

std::unique_ptr<OGRCoordinateTransformation> connect(const GridPlace& from, const GridPlace& to,
                                                     const std::string& name) {
  if (from.crs.empty() || to.crs.empty()) return nullptr;
  const OGRSpatialReference a = parse_crs(from.crs, name);
  const OGRSpatialReference b = parse_crs(to.crs, name);
  if (a.IsSame(&b) != 0) return nullptr;
  std::unique_ptr<OGRCoordinateTransformation> result(OGRCreateCoordinateTransformation(&a, &b));
  if (!result) {
    throw Error(ErrorCode::InvalidInput,
                fmt::format("{}: no transformation from '{}' to '{}' is known: name another --crs",
                            name, a.GetName(), b.GetName()));
  }
  return result;
}

}  // namespace

GridMap::GridMap(const GridPlace& from, const GridPlace& to, const std::string& name,
                 double tolerance)
    : from_(from.crs_from_post), to_(to.crs_from_post) {
  const Messages messages;
  crs_ = connect(from, to, name);
  approximate_ = GDALCreateApproxTransformer(transform, this, tolerance);
}

GridMap::~GridMap() {
  GDALDestroyApproxTransformer(approximate_);
}

// GDAL's callback: posts of `from` to posts of `to`, exactly.
// NOLINTNEXTLINE(readability-function-size): the signature is GDAL's
int GridMap::transform(void* self, int, int count, double* x, double* y, double*, int* success) {
  const auto& map = *static_cast<const GridMap*>(self);
  for (int i = 0; i < count; ++i) {
    const glm::dvec2 p = map.from_.apply(x[i], y[i]);
    x[i] = p.x;
    y[i] = p.y;
    success[i] = 1;
  }
  if (map.crs_) map.crs_->Transform(count, x, y, nullptr, nullptr, success);
  for (int i = 0; i < count; ++i) {
    const glm::dvec2 p = map.to_.inverse({x[i], y[i]});
    success[i] = success[i] != 0 && std::isfinite(p.x) && std::isfinite(p.y) ? 1 : 0;
    x[i] = success[i] != 0 ? p.x : HUGE_VAL;
    y[i] = success[i] != 0 ? p.y : HUGE_VAL;
  }
  return 1;
}

void GridMap::map_row(double first_col, double col_step, double row, std::span<double> cols,
                      std::span<double> rows) const {
  for (std::size_t i = 0; i < cols.size(); ++i) {
    cols[i] = first_col + col_step * static_cast<double>(i);
    rows[i] = row;
  }
  std::vector<double> z(cols.size());
  std::vector<int> success(cols.size());
  const Messages messages;
  GDALApproxTransform(approximate_, 0, static_cast<int>(cols.size()), cols.data(), rows.data(),
                      z.data(), success.data());
  for (std::size_t i = 0; i < cols.size(); ++i) {
    if (success[i] == 0) cols[i] = rows[i] = std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace arete::raster
