#pragma once

#include <string>

#include "arete/core/georef.h"
#include "arete/raster/lon_lat.h"

namespace arete::app {

/// Says where a point of the world lies, as people write it.
class Place {
 public:
  explicit Place(const Georef& georef);
  /// A line with CRS coordinates, or with latitude and longitude, or both on two lines.
  std::string text(glm::dvec2 world) const;

 private:
  Georef georef_;
  raster::LonLatFromCrs lon_lat_;
};

/// "37.26818° N  104.66645° W"
std::string lat_lon_text(glm::dvec2 lon_lat);

}  // namespace arete::app
