#include <benchmark/benchmark.h>

#include "arete/core/normal_code.h"
#include "arete/core/screen_error.h"
#include "arete/core/view.h"

namespace arete {
namespace {

View some_view() {
  return make_view({.eye = {1000, -2000, 900}, .yaw = 0.7, .pitch = -0.3}, 1280, 720);
}

void frustum_test_of_a_box(benchmark::State& state) {
  const auto planes = frustum_planes(some_view());
  double x = 0;
  for (auto _ : state) {
    x = x > 30000 ? 0 : x + 17;
    benchmark::DoNotOptimize(may_see(planes, {x, -3000, 0}, {x + 500, -2500, 300}));
  }
}
BENCHMARK(frustum_test_of_a_box);

void error_to_pixels(benchmark::State& state) {
  const ScreenError error(some_view(), 1);
  double distance = 100;
  for (auto _ : state) {
    distance += 0.5;
    benchmark::DoNotOptimize(error.pixels(2.5, distance));
  }
}
BENCHMARK(error_to_pixels);

void encode_a_normal(benchmark::State& state) {
  glm::dvec3 normal{0.1, -0.3, 0.9};
  for (auto _ : state) {
    normal.x += 1e-6;
    benchmark::DoNotOptimize(encode_normal(normal));
  }
}
BENCHMARK(encode_a_normal);

}  // namespace
}  // namespace arete
