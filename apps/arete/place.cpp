#include "place.h"

#include <cmath>

#include <fmt/format.h>

namespace arete::app {

Place::Place(const Georef& georef)
    : georef_(georef), lon_lat_(raster::lon_lat_from_crs(georef.crs)) {}

std::string Place::text(glm::dvec2 world) const {
  const glm::dvec2 post = georef_.world_from_post.inverse(world);
  const glm::dvec2 at = georef_.crs_from_post.apply(post.x, post.y);
  const auto lon_lat = lon_lat_ ? lon_lat_(at) : std::nullopt;
  if (lon_lat && glm::length(*lon_lat - at) < 1e-6) {  // the CRS itself counts in degrees
    return lat_lon_text(*lon_lat);
  }
  const std::string xy = fmt::format("x {:.2f}  y {:.2f}", at.x, at.y);
  return lon_lat ? xy + '\n' + lat_lon_text(*lon_lat) : xy;
}

std::string lat_lon_text(glm::dvec2 lon_lat) {
  const double lon = std::remainder(lon_lat.x, 360);
  // The overlay's font has ASCII and Latin-1: the degree sign is in both.
  return fmt::format("{:.5f}\u00b0 {}  {:.5f}\u00b0 {}", std::abs(lon_lat.y),
                     lon_lat.y < 0 ? 'S' : 'N', std::abs(lon), lon < 0 ? 'W' : 'E');
}

}  // namespace arete::app
