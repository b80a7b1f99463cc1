#include <benchmark/benchmark.h>

#include "built_store.h"

namespace arete::bench {
namespace {

void decode_a_height_tile(benchmark::State& state) {
  std::uint32_t next = 0;
  auto terrain = open_built_store();
  const auto across = static_cast<std::uint32_t>(terrain->tiles_x(0));
  for (auto _ : state) {
    if (next == across * across) {
      state.PauseTiming();
      terrain = open_built_store();
      next = 0;
      state.ResumeTiming();
    }
    benchmark::DoNotOptimize(
        terrain->heights({0, next % across, next / across}, store::Fetch::Wait));
    ++next;
  }
  state.SetItemsProcessed(state.iterations() * store::kTileCells * store::kTileCells);
}
BENCHMARK(decode_a_height_tile);

void find_a_height_tile_in_the_cache(benchmark::State& state) {
  const auto terrain = open_built_store();
  for (auto _ : state) {
    benchmark::DoNotOptimize(terrain->heights({0, 1, 1}, store::Fetch::Wait));
  }
}
BENCHMARK(find_a_height_tile_in_the_cache);

void read_all_rows(benchmark::State& state) {
  const auto terrain = open_built_store();
  const auto source = terrain->height_source();
  std::vector<float> row(static_cast<std::size_t>(source->cols()));
  for (auto _ : state) {
    for (int r = 0; r < source->rows(); ++r) {
      source->read_row(r, row);
    }
  }
  state.SetItemsProcessed(state.iterations() * source->cols() * source->rows());
}
BENCHMARK(read_all_rows)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace arete::bench
