#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "arete/core/heightfield.h"
#include "arete/lod/engine.h"
#include "arete/store/build.h"
#include "arete/store/terrain.h"

namespace arete::lod {

/// The params that the method knows: `patch` is of methods with patches only.
Params params_for(std::string_view method, Params params);

/// A store of a DEM with every method's segments, in a folder of its own that goes with it.
class BuiltTerrain {
 public:
  explicit BuiltTerrain(Heightfield dem, const Params& params = {});
  ~BuiltTerrain();
  BuiltTerrain(const BuiltTerrain&) = delete;
  BuiltTerrain& operator=(const BuiltTerrain&) = delete;

  const Heightfield& dem() const { return dem_; }  ///< as stored
  std::unique_ptr<store::Terrain> open(store::OpenOptions options = {}) const;

 private:
  std::filesystem::path folder_;
  Heightfield dem_;
};

/// A view of rough_dem(257, 193, ...) along a winding flight, t in 0..1.
View flight_view(double t);

/// A seeded DEM with holes where `hole_share` > 0.
Heightfield rough_dem(int cols, int rows, std::uint64_t seed, double hole_share);

}  // namespace arete::lod
