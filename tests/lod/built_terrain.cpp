#include "lod/built_terrain.h"

#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

namespace arete::lod {

Params params_for(std::string_view method, Params params) {
  if (method == "soar" || method == "smart") params.erase("patch");
  return params;
}

BuiltTerrain::BuiltTerrain(Heightfield dem, const Params& params) : dem_(std::move(dem)) {
  static std::atomic<int> counter{0};
  folder_ = std::filesystem::temp_directory_path() /
            fmt::format("arete-lod-{}-{}", ::getpid(), ++counter);
  std::filesystem::create_directories(folder_);
  store::BuildOptions options;
  options.output = folder_ / "t.arete";
  options.source_key = "test";
  options.preprocess = [&](const store::Terrain& terrain, store::Writers& writers) {
    for (const EngineInfo& info : engines()) {
      info.preprocess(terrain, writers, {}, params_for(info.name, params));
      options.methods.emplace_back(info.name);
    }
  };
  store::build(dem_, options, {});
  dem_ = Heightfield(*open()->height_source());
}

BuiltTerrain::~BuiltTerrain() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::unique_ptr<store::Terrain> BuiltTerrain::open(store::OpenOptions options) const {
  return store::Terrain::open(folder_ / "t.arete", std::move(options));
}

View flight_view(double t) {
  return make_view(
      {.eye = {500 + 5000 * t, -2500 + 400 * std::sin(7 * t), 900 + 200 * std::cos(9 * t)},
       .yaw = 1 + 3 * t,
       .pitch = -0.3,
       .near_m = 1},
      320, 240);
}

Heightfield rough_dem(int cols, int rows, std::uint64_t seed, double hole_share) {
  std::mt19937_64 random(seed);
  std::normal_distribution<float> noise(0, 6);
  std::uniform_real_distribution<double> unit(0, 1);
  Georef georef;
  georef.world_from_post.m = {30, 0, 0, 0, -30, 0};
  Heightfield dem(cols, rows, georef);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      const double hills =
          300 * std::sin(c * 0.031) * std::cos(r * 0.023) + 80 * std::sin(0.2 * c + 0.1 * r);
      dem[{c, r}] = static_cast<float>(500 + hills) + noise(random);
    }
  }
  for (int k = 0; hole_share > 0 && k < 12; ++k) {  // rectangles without data
    const int w = std::max(1, static_cast<int>(cols * hole_share * unit(random)));
    const int h = std::max(1, static_cast<int>(rows * hole_share * unit(random)));
    const int c0 = static_cast<int>(unit(random) * (cols - w));
    const int r0 = static_cast<int>(unit(random) * (rows - h));
    for (int r = r0; r < r0 + h; ++r) {
      for (int c = c0; c < c0 + w; ++c) dem[{c, r}] = std::numeric_limits<float>::quiet_NaN();
    }
  }
  return dem;
}

}  // namespace arete::lod
