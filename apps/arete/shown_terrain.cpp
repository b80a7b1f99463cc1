#include "shown_terrain.h"

#include <utility>

#include "budgets.h"

namespace arete::app {

OpenedTerrain open_with_method(const TerrainFlags& flags, const std::filesystem::path& store,
                               const std::string& method) {
  OpenedTerrain opened;
  opened.source = flags.terrain;
  opened.terrain = open_store(flags, store);
  opened.method = method;
  opened.engine = open_method(flags, method, *opened.terrain);
  return opened;
}

ShownTerrain::ShownTerrain(OpenedTerrain opened, std::size_t gpu_memory)
    : opened_(std::move(opened)),
      footprint_(opened_.engine->footprint()),
      rasters_(*opened_.terrain),
      ground_(ground_of(*opened_.terrain, store::Fetch::Wait)),
      cursor_ground_(ground_of(*opened_.terrain, store::Fetch::Resident)),
      place_(opened_.terrain->manifest().georef),
      renderer_(rasters_.land, gpu_memory) {}

void ShownTerrain::change_method(const TerrainFlags& flags, const std::string& method) {
  auto engine = open_method(flags, method, *opened_.terrain);
  renderer_.forget(*opened_.engine);
  opened_.engine = std::move(engine);
  footprint_ = opened_.engine->footprint();
  opened_.method = method;
  list_.clear();
  refined_ = false;
}

lod::Budget ShownTerrain::budget_under(const FlightFlags& flags) const {
  return budget_of(flags, opened_.method, *opened_.terrain, *opened_.engine, &renderer_);
}

std::uint64_t ShownTerrain::bytes() const {
  return terrain_bytes(*opened_.terrain, footprint_, list_.stats);
}

void ShownTerrain::refine(const View& view, const lod::RefineOptions& options) {
  opened_.engine->refine(view, options, list_);
  refined_ = true;
}

void ShownTerrain::draw(const View& view, const render::Style& style, render::Frame& frame) {
  renderer_.draw(view, list_, *opened_.engine, style, frame);
}

}  // namespace arete::app
