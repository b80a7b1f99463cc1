#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/raster/dem.h"
#include "arete/render/headless.h"
#include "arete/render/renderer.h"

#include "budgets.h"
#include "flags.h"
#include "ground.h"
#include "interrupt.h"
#include "land_rasters.h"
#include "picture_output.h"
#include "text_file.h"
#include "verbs.h"

namespace arete::app {
namespace {

namespace fs = std::filesystem;

struct RenderFlags {
  FlightFlags flight;
  std::string method = "geomipmap";
  fs::path output, stats, depth;
  double at = 0;
  int frames_per_second = 30;
  render::Style style;
};

constexpr const char* kStatsHeader =
    "frame,seconds,triangles,draws,visited_nodes,evaluated_vertices,culled,late_blocks,"
    "bytes_uploaded,gpu_bytes,achieved_error_px,refine_ms,draw_ms,tolerance_px,resident_bytes,"
    "cache_bytes,terrain_bytes\n";

/// Everything that one frame needs, opened once.
class Studio {
 public:
  explicit Studio(const RenderFlags& flags)
      : flags_(flags),
        terrain_(open_terrain(flags.flight.terrain, {flags.method})),
        engine_(open_method(flags.flight.terrain, flags.method, *terrain_)),
        rasters_(*terrain_),
        renderer_(rasters_.land, renderer_memory(flags.flight)),
        frame_(flags.flight.size.width, flags.flight.size.height),
        path_(scene::make_path(flags.flight.path, ground_of(*terrain_, store::Fetch::Wait))),
        options_(flags.flight.refine_options()) {
    options_.budget = budget_of(flags.flight, flags.method, *terrain_, *engine_, &renderer_);
  }

  const scene::Path& path() const { return path_; }
  void tell_of_damage() const { app::tell_of_damage(*terrain_, flags_.flight.terrain); }
  const render::Frame& frame() const { return frame_; }

  /// Draws the instant and gives its line of --stats.
  std::string shoot(int index, double seconds) {
    const auto start = std::chrono::steady_clock::now();
    view_ = make_view(path_.at(seconds), frame_.width(), frame_.height());
    engine_->refine(view_, options_, list_);
    const auto refined = std::chrono::steady_clock::now();
    renderer_.draw(view_, list_, *engine_, flags_.style, frame_);
    require_all_drawn(renderer_);
    rgb_ = frame_.read_rgb();
    const auto drawn = std::chrono::steady_clock::now();
    using Ms = std::chrono::duration<double, std::milli>;
    const RefineStats& s = list_.stats;
    const render::DrawStats& d = renderer_.stats();
    return fmt::format(
        "{},{:.6f},{},{},{},{},{},{},{},{},{:.4f},{:.3f},{:.3f},{:.4f},{},{},{}\n", index, seconds,
        s.triangles, d.draws, s.visited_nodes, s.evaluated_vertices, s.culled, s.late_blocks,
        d.bytes_uploaded, d.gpu_bytes + frame_bytes(), s.achieved_error_px,
        Ms(refined - start).count(), Ms(drawn - refined).count(), s.tolerance_px, s.resident_bytes,
        terrain_->cache_stats().resident_bytes, terrain_bytes(*terrain_, engine_->footprint(), s));
  }
  const std::vector<std::uint8_t>& rgb() const { return rgb_; }

  /// Metres along the view axis; NaN where nothing is drawn.
  std::vector<float> distances() const {
    std::vector<float> depth = frame_.read_depth();
    for (float& d : depth) {
      d = d > 0 ? static_cast<float>(view_.near_m) / d : std::numeric_limits<float>::quiet_NaN();
    }
    return depth;
  }

 private:
  std::uint64_t frame_bytes() const {
    return render::Frame::bytes(frame_.width(), frame_.height());
  }

  const RenderFlags& flags_;
  render::HeadlessContext context_;
  std::unique_ptr<store::Terrain> terrain_;
  std::unique_ptr<lod::Engine> engine_;
  LandRasters rasters_;
  render::Renderer renderer_;
  render::Frame frame_;
  scene::Path path_;
  lod::RefineOptions options_;
  View view_;
  DrawList list_;
  std::vector<std::uint8_t> rgb_;
};

void write_depth(const RenderFlags& flags, const Studio& studio) {
  fs::remove(flags.depth);  // the GeoTIFF writer refuses files that exist
  raster::write_geotiff(flags.depth, studio.frame().width(), studio.frame().height(),
                        studio.distances().data());
}

void run(const RenderFlags& flags) {
  const bool still = picture_kind(flags.output) == PictureKind::Still;
  if (!still && !flags.depth.empty()) {
    throw Error(ErrorCode::Usage, "--depth: goes with one picture: render to a .png");
  }
  Studio studio(flags);
  const auto output = open_output(flags.output, flags.flight.size, flags.frames_per_second);
  const int frames = still ? 1 : flags.flight.frames;
  std::string stats = kStatsHeader;
  ProgressBar bar(flags.flight.terrain.talk);
  for (int i = 0; i < frames; ++i) {
    stop_if_interrupted(flags.output.string());
    stats += studio.shoot(i, still ? flags.at : instant(studio.path(), i, frames));
    output->add(studio.rgb());
    bar.show("rendering", static_cast<double>(i + 1) / frames);
  }
  if (!flags.depth.empty()) {
    write_depth(flags, studio);
  }
  if (!flags.stats.empty()) {
    write_text(flags.stats, stats);
  }
  output->finish();
  studio.tell_of_damage();
}

void add_flags(CLI::App& verb, RenderFlags& flags) {
  add_terrain(verb, flags.flight.terrain);
  verb.add_option("-o,--output", flags.output, "out.png, out.mp4, or a directory for numbered PNGs")
      ->required();
  add_method(verb, flags.method);
  add_flight(verb, flags.flight);
  add_frames(verb, flags.flight.frames);
  add_missing(verb, flags.flight);
  verb.add_option("--at", flags.at, "Second of the path that a .png shows")->capture_default_str();
  verb.add_option("--fps", flags.frames_per_second, "Frames a second of a .mp4")
      ->capture_default_str()
      ->check(CLI::Range(1, 240));
  verb.add_flag("--wireframe", flags.style.wireframe, "Draw the edges of triangles");
  verb.add_flag_callback(
      "--no-morph", [&flags] { flags.style.morph = false; }, "Draw without geomorphs");
  verb.add_option("--stats", flags.stats, "A line a frame as CSV")->type_name("CSV");
  verb.add_option("--depth", flags.depth, "Metres along the view axis as GeoTIFF")
      ->type_name("TIF");
  add_quiet(verb, flags.flight.terrain.talk);
}

}  // namespace

void add_render(CLI::App& app) {
  auto flags = std::make_shared<RenderFlags>();
  CLI::App* const verb =
      add_verb(app, "render", "Draw pictures or a video without a display",
               "arete render alps.arete -o flight.mp4 --method smooth --frames 300");
  add_flags(*verb, *flags);
  verb->callback([flags] { run(*flags); });
}

}  // namespace arete::app
