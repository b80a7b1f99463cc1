#include <string>

#include <benchmark/benchmark.h>

#include "arete/core/heightfield.h"
#include "arete/lod/engine.h"
#include "arete/mesh/surface.h"

#include "built_store.h"

namespace arete::bench {
namespace {

/// A slow flight to the north over the middle of the terrain.
View view_of(int frame) {
  const double y = -25000 + 20.0 * (frame % 500);
  return make_view({.eye = {15000, y, 1200}, .pitch = -0.25}, 1280, 720);
}

void refine_along_a_flight(benchmark::State& state, const lod::EngineInfo& info) {
  const auto terrain = open_built_store();
  const auto engine = info.open(*terrain, {});
  DrawList list;
  int frame = 0;
  double triangles = 0;
  for (auto _ : state) {
    engine->refine(view_of(frame++), {}, list);
    triangles += static_cast<double>(list.stats.triangles);
  }
  state.counters["triangles"] = triangles / frame;
}

void flatten_a_frame(benchmark::State& state) {
  const auto terrain = open_built_store();
  const auto engine = lod::find_engine("geomipmap").open(*terrain, {});
  DrawList list;
  engine->refine(view_of(0), {}, list);
  mesh::Surface surface;
  for (auto _ : state) {
    mesh::flatten(list, *engine, surface);
    benchmark::DoNotOptimize(surface.vertices.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(list.stats.triangles));
}
BENCHMARK(flatten_a_frame)->Unit(benchmark::kMillisecond);

void check_a_frame(benchmark::State& state) {
  const auto terrain = open_built_store();
  const auto engine = lod::find_engine("geomipmap").open(*terrain, {});
  const Heightfield dem(*terrain->height_source());
  const View view = view_of(0);
  DrawList list;
  engine->refine(view, {}, list);
  mesh::Surface surface;
  mesh::flatten(list, *engine, surface);
  for (auto _ : state) {
    benchmark::DoNotOptimize(mesh::check_surface(surface, dem, &view).cracks());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(list.stats.triangles));
}
BENCHMARK(check_a_frame)->Unit(benchmark::kMillisecond);

const int registered = [] {
  for (const lod::EngineInfo& info : lod::engines()) {
    benchmark::RegisterBenchmark(("refine_along_a_flight/" + std::string(info.name)).c_str(),
                                 refine_along_a_flight, info)
        ->Unit(benchmark::kMillisecond);
  }
  return 0;
}();

}  // namespace
}  // namespace arete::bench
