// Opens a store, refines it for one view, and says what would be drawn.
#include <cstdio>
#include <exception>

#include "arete/lod/engine.h"
#include "arete/store/terrain.h"

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fprintf(stderr, "usage: fly STORE\n");
    return 2;
  }
  const auto terrain = arete::store::Terrain::open(argv[1]);
  const auto engine = arete::lod::find_engine("geomipmap").open(*terrain, {});
  const auto& land = terrain->manifest();
  const glm::dvec2 centre = land.georef.world_from_post.apply(land.cols / 2.0, land.rows / 2.0);
  const arete::View view =
      arete::make_view({.eye = {centre, land.z_max + 500}, .pitch = -0.4}, 1280, 720);
  arete::DrawList list;
  engine->refine(view, {.tolerance_px = 1}, list);
  std::printf("%llu triangles within %.2f px\n",
              static_cast<unsigned long long>(list.stats.triangles), list.stats.achieved_error_px);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "fly: %s\n", error.what());
  return 1;
}
