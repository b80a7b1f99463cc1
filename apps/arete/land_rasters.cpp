#include "land_rasters.h"

#include <cstdlib>
#include <string>

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::app {
namespace {

// The body by the ellipsoid's semi-major axis, the first number after its name in WKT:
// ELLIPSOID["name",6378137,... or SPHEROID[...].
render::Body body_of(const std::string& wkt) {
  for (const char* word : {"ELLIPSOID[\"", "SPHEROID[\""}) {
    const std::size_t at = wkt.find(word);
    if (at == std::string::npos) continue;
    const std::size_t comma = wkt.find(',', at);
    if (comma == std::string::npos) continue;
    const double radius_m = std::strtod(wkt.c_str() + comma + 1, nullptr);
    if (radius_m > 6.0e6 && radius_m < 6.6e6) return render::Body::Earth;
    if (radius_m > 3.3e6 && radius_m < 3.5e6) return render::Body::Mars;
    return render::Body::Airless;
  }
  return render::Body::Earth;
}

}  // namespace

LandRasters::LandRasters(const store::Terrain& terrain)
    : normals_(terrain.raster("normals")),
      validity_(terrain.raster("mask")),
      drape_(terrain.raster("drape")) {
  const store::Manifest& m = terrain.manifest();
  land.world_from_post = m.georef.world_from_post;
  land.cols = m.cols;
  land.rows = m.rows;
  land.z_min = m.z_min;
  land.z_max = m.z_max;
  land.body = body_of(m.georef.crs);
  land.normals = normals_.get();
  land.validity = validity_.get();
  land.drape = drape_.get();
}

void require_all_drawn(const render::Renderer& renderer) {
  if (const std::uint64_t dropped = renderer.stats().dropped_batches; dropped > 0) {
    throw Error(ErrorCode::Limit,
                fmt::format("--gpu-memory: {} batches of a frame do not fit: give it more, or a "
                            "larger --tolerance",
                            dropped));
  }
}

}  // namespace arete::app
