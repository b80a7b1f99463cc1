#include "bench_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include <epoxy/gl.h>

#include "arete/proof/incoherence.h"
#include "arete/render/renderer.h"

#include "budgets.h"
#include "ground.h"
#include "interrupt.h"
#include "land_rasters.h"
#include "process_usage.h"

namespace arete::app {
namespace {

using Clock = std::chrono::steady_clock;

double ms(Clock::duration d) {
  return std::chrono::duration<double, std::milli>(d).count();
}

/// A renderer with its frame, or nothing when drawing is skipped.
struct Canvas {
  Canvas(const store::Terrain& terrain, const FlightFlags& flags)
      : rasters(terrain),
        renderer(rasters.land, renderer_memory(flags)),
        frame(flags.size.width, flags.size.height) {}

  // Waits for the picture: without it a software rasteriser's time would fall into the next frame.
  void draw(const View& view, const DrawList& list, const BlockSource& blocks) {
    renderer.draw(view, list, blocks, render::Style{}, frame);
    require_all_drawn(renderer);
    glFinish();
  }

  LandRasters rasters;
  render::Renderer renderer;
  render::Frame frame;
};

void add_stats(const RefineStats& stats, BenchRun& run) {
  run.mean_triangles += static_cast<double>(stats.triangles) / run.frames;
  run.mean_full_triangles += static_cast<double>(stats.full_triangles) / run.frames;
  run.triangles.push_back(static_cast<double>(stats.triangles));
  run.evaluated_vertices += stats.evaluated_vertices;
  run.visited_nodes += stats.visited_nodes;
  run.late_blocks += stats.late_blocks;
  run.achieved_error_px = std::max(run.achieved_error_px, stats.achieved_error_px);
  run.tolerance_px = std::max(run.tolerance_px, stats.tolerance_px);
  run.max_triangles = std::max(run.max_triangles, stats.triangles);
  run.resident_bytes_max = std::max(run.resident_bytes_max, stats.resident_bytes);
}

}  // namespace

double quantile(std::vector<double> samples, double share) {
  if (samples.empty()) {
    return 0;
  }
  std::ranges::sort(samples);
  const double rank = std::ceil(share * static_cast<double>(samples.size()));
  return samples[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

BenchRun bench_method(const FlightFlags& flags, const std::string& method, Drawing drawing) {
  reset_peak_rss();
  const auto terrain = open_terrain(flags.terrain, {method});
  const auto engine = open_method(flags.terrain, method, *terrain);
  const scene::Path path = scene::make_path(flags.path, ground_of(*terrain, store::Fetch::Wait));
  std::optional<Canvas> canvas;
  if (drawing == Drawing::Draw) {
    canvas.emplace(*terrain, flags);
  }
  lod::RefineOptions options = flags.refine_options();
  options.budget =
      budget_of(flags, method, *terrain, *engine, canvas ? &canvas->renderer : nullptr);
  BenchRun run;
  run.method = method;
  run.frames = flags.frames;
  const std::uint64_t faults = major_page_faults();
  proof::Incoherence incoherence;
  DrawList list;
  const lod::Footprint footprint = engine->footprint();
  ProgressBar bar(flags.terrain.talk);
  for (int i = 0; i < flags.frames; ++i) {
    stop_if_interrupted(flags.terrain.terrain.string());
    const View view =
        make_view(path.at(instant(path, i, flags.frames)), flags.size.width, flags.size.height);
    const auto start = Clock::now();
    engine->refine(view, options, list);
    const auto refined = Clock::now();
    run.refine_ms.push_back(ms(refined - start));
    if (canvas) {
      canvas->draw(view, list, *engine);
      run.draw_ms.push_back(ms(Clock::now() - refined));
      run.bytes_uploaded += canvas->renderer.stats().bytes_uploaded;
      run.gpu_bytes_max = std::max(run.gpu_bytes_max,
                                   canvas->renderer.stats().gpu_bytes +
                                       render::Frame::bytes(flags.size.width, flags.size.height));
    }
    run.frame_ms.push_back(ms(Clock::now() - start));
    add_stats(list.stats, run);
    run.terrain_bytes_max =
        std::max(run.terrain_bytes_max, terrain_bytes(*terrain, footprint, list.stats));
    incoherence.add(list, *engine);
    bar.show(method, static_cast<double>(i + 1) / flags.frames);
  }
  run.incoherence_percent = incoherence.percent();
  run.page_faults = major_page_faults() - faults;
  run.bytes_read = terrain->cache_stats().bytes_read;
  run.cache_bytes_max = terrain->cache_stats().resident_bytes_max;
  run.peak_rss_bytes = peak_rss_bytes();
  bar.clear();
  tell_of_damage(*terrain, flags.terrain);
  return run;
}

}  // namespace arete::app
