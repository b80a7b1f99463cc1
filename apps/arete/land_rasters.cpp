#include "land_rasters.h"

namespace arete::app {

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
  land.normals = normals_.get();
  land.validity = validity_.get();
  land.drape = drape_.get();
}

}  // namespace arete::app
