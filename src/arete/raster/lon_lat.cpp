#include "arete/raster/lon_lat.h"

#include <cmath>
#include <memory>

#include <ogr_spatialref.h>

#include "arete/core/error.h"
#include "arete/raster/fence.h"
#include "arete/raster/placement.h"

namespace arete::raster {

LonLatFromCrs lon_lat_from_crs(const std::string& crs) {
  raise_fence();
  const Messages messages;
  if (crs.empty()) return {};
  try {
    const OGRSpatialReference from = parse_crs(crs, "CRS");
    const std::unique_ptr<OGRSpatialReference> to(from.CloneGeogCS());
    if (!to) return {};
    to->SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const std::shared_ptr<OGRCoordinateTransformation> transformation(
        OGRCreateCoordinateTransformation(&from, to.get()));
    if (!transformation) return {};
    return [transformation](glm::dvec2 at) -> std::optional<glm::dvec2> {
      const Messages quiet;
      if (transformation->Transform(1, &at.x, &at.y) == 0 || !std::isfinite(at.x) ||
          !std::isfinite(at.y))
        return std::nullopt;
      return at;
    };
  } catch (const Error&) {
    return {};
  }
}

}  // namespace arete::raster
