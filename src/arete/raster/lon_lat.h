#pragma once

#include <functional>
#include <optional>
#include <string>

#include <glm/glm.hpp>

namespace arete::raster {

/// Longitude and latitude, degrees, of a point in CRS units; nothing where the CRS does not reach.
using LonLatFromCrs = std::function<std::optional<glm::dvec2>(glm::dvec2)>;

/// For a CRS as in Georef::crs, on the body's own ellipsoid. Empty when the CRS says nothing of
/// where on a body it lies. Thread contract: one thread at a time. Throws: nothing.
LonLatFromCrs lon_lat_from_crs(const std::string& crs);

}  // namespace arete::raster
