// What a visited node of the bin-tree costs, warm, on a flight over the store that the environment
// variable ARETE_BENCH_STORE names, or over the synthetic one. Times are the thread's own processor
// time; on a shared machine the least of the repetitions is the figure.
#include <algorithm>
#include <cstdlib>
#include <vector>

#include <benchmark/benchmark.h>

#include "arete/lod/engine.h"

#include "built_store.h"
#include "ground.h"

namespace arete::bench {
namespace {

constexpr int kFrames = 100;

std::vector<View> flyover(const store::Terrain& terrain) {
  const scene::Path path = scene::make_path("flyover", app::ground_of(terrain, store::Fetch::Wait));
  std::vector<View> views;
  for (int i = 0; i < kFrames; ++i)
    views.push_back(make_view(path.at(path.duration() * i / kFrames), 800, 600));
  return views;
}

void visit_nodes(benchmark::State& state, const lod::Params& params) {
  const char* named = std::getenv("ARETE_BENCH_STORE");
  const auto terrain = named != nullptr ? store::Terrain::open(named) : open_built_store();
  const std::vector<View> views = flyover(*terrain);
  const auto engine = lod::find_engine("soar").open(*terrain, params);
  const lod::RefineOptions options{.tolerance_px = 1, .scale = ErrorScale::Angular};
  DrawList list;
  const auto fly = [&] {
    double nodes = 0;
    for (const View& view : views) {
      engine->refine(view, options, list);
      nodes += static_cast<double>(list.stats.visited_nodes);
    }
    return nodes;
  };
  double nodes = fly();  // reads the pages
  state.counters["nodes_a_frame"] = nodes / kFrames;
  nodes = 0;
  for (auto _ : state) nodes += fly();
  using benchmark::Counter;
  state.counters["s_a_node"] = Counter(nodes, Counter::kIsRate | Counter::kInvert);
}

double least(const std::vector<double>& times) {
  return *std::ranges::min_element(times);
}

BENCHMARK_CAPTURE(visit_nodes, soar, {})
    ->Unit(benchmark::kMillisecond)
    ->Repetitions(15)
    ->ReportAggregatesOnly()
    ->ComputeStatistics("least", least);
BENCHMARK_CAPTURE(visit_nodes, soar_morph, {{"morph", "true"}})
    ->Unit(benchmark::kMillisecond)
    ->Repetitions(15)
    ->ReportAggregatesOnly()
    ->ComputeStatistics("least", least);

}  // namespace
}  // namespace arete::bench
