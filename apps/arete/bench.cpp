#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "arete/render/headless.h"

#include "bench_paper.h"
#include "bench_report.h"
#include "bench_run.h"
#include "flags.h"
#include "json.h"
#include "text_file.h"
#include "verbs.h"

namespace arete::app {
namespace {

struct BenchFlags {
  FlightFlags flight;
  std::string methods = "all";
  Drawing drawing = Drawing::Draw;
  std::filesystem::path report;
  std::string paper;
  bool json = false;
};

Json times_json(const std::vector<double>& samples) {
  if (samples.empty()) {
    return nullptr;
  }
  return {{"p50", quantile(samples, 0.5)},
          {"p99", quantile(samples, 0.99)},
          {"max", quantile(samples, 1)}};
}

Json json_of(const BenchFlags& flags, const BenchRun& r) {
  return {{"method", r.method},
          {"options", options_json(flags.flight, r.method)},
          {"frames", r.frames},
          {"mean_triangles", r.mean_triangles},
          {"mean_full_triangles", r.mean_full_triangles},
          {"refine_ms", times_json(r.refine_ms)},
          {"draw_ms", times_json(r.draw_ms)},
          {"frame_ms", times_json(r.frame_ms)},
          {"evaluated_vertices", r.evaluated_vertices},
          {"visited_nodes", r.visited_nodes},
          {"late_blocks", r.late_blocks},
          {"bytes_read", r.bytes_read},
          {"page_faults", r.page_faults},
          {"bytes_uploaded", r.bytes_uploaded},
          {"incoherence_percent", r.incoherence_percent},
          {"cache_bytes_max", r.cache_bytes_max},
          {"resident_bytes_max", r.resident_bytes_max},
          {"terrain_bytes_max", r.terrain_bytes_max},
          {"gpu_bytes_max", r.gpu_bytes_max},
          {"max_triangles", r.max_triangles},
          {"peak_rss_bytes", r.peak_rss_bytes},
          {"max_tolerance_px", finite(r.tolerance_px)},
          {"achieved_error_px", finite(r.achieved_error_px)}};
}

void print_header() {
  fmt::print("{:<12}{:>12}{:>20}{:>20}{:>12}{:>12}{:>12}{:>10}\n", "method", "triangles",
             "refine p50/p99 ms", "frame p50/p99 ms", "read", "uploaded", "changed %", "error px");
}

void print_row(const BenchRun& r) {
  fmt::print(
      "{:<12}{:>12}{:>20}{:>20}{:>12}{:>12}{:>12.2f}{:>10.3f}\n", r.method,
      grouped(static_cast<unsigned long long>(r.mean_triangles)),
      fmt::format("{:.2f} / {:.2f}", quantile(r.refine_ms, 0.5), quantile(r.refine_ms, 0.99)),
      fmt::format("{:.2f} / {:.2f}", quantile(r.frame_ms, 0.5), quantile(r.frame_ms, 0.99)),
      bytes_text(static_cast<double>(r.bytes_read)),
      bytes_text(static_cast<double>(r.bytes_uploaded)), r.incoherence_percent,
      r.achieved_error_px);
}

std::string heading(const BenchFlags& flags, const Json& machine) {
  const FlightFlags& f = flags.flight;
  const Json& gl = machine["gl_renderer"];
  return fmt::format("{}, path {}, {} frames of {} x {}, tolerance {:g} px. {}, {} threads, {}.",
                     f.terrain.terrain.filename().string(), f.path, f.frames, f.size.width,
                     f.size.height, f.refine_options().tolerance_px,
                     machine["cpu"].get<std::string>(), machine["threads"].get<int>(),
                     gl.is_null() ? "nothing drawn" : gl.get<std::string>());
}

/// Flies every method in turn, saying each one's row as it is done.
std::vector<BenchRun> bench_methods(const BenchFlags& flags,
                                    const std::vector<std::string>& methods) {
  FlightFlags flight = flags.flight;
  flight.terrain.terrain = store_of(flags.flight.terrain, methods);
  if (!flags.json) {
    print_header();
  }
  std::vector<BenchRun> runs;
  for (const std::string& method : methods) {
    runs.push_back(bench_method(flight, method, flags.drawing));
    if (!flags.json) {
      print_row(runs.back());
    }
  }
  return runs;
}

void run(const BenchFlags& flags) {
  if (!flags.paper.empty()) {
    return bench_paper(flags.flight, flags.paper, flags.json ? Format::Json : Format::Text);
  }
  std::optional<render::HeadlessContext> context;
  if (flags.drawing == Drawing::Draw) {
    context.emplace();
  }
  const Json machine = machine_json(context ? context->renderer() : "");
  const std::vector<BenchRun> runs = bench_methods(flags, method_list(flags.methods));
  if (!flags.report.empty()) {
    write_text(flags.report, bench_report(heading(flags, machine), runs));
  }
  if (flags.json) {
    Json rows = Json::array();
    for (const BenchRun& result : runs) {
      rows.push_back(json_of(flags, result));
    }
    print_json({{"machine", machine},
                {"terrain", flags.flight.terrain.terrain.string()},
                {"path", flags.flight.path},
                {"runs", rows}});
  }
}

}  // namespace

void add_bench(CLI::App& app) {
  auto flags = std::make_shared<BenchFlags>();
  CLI::App* const verb = add_verb(app, "bench", "Fly one path with several methods and time them",
                                  "arete bench alps.arete --methods full,geomipmap,smooth --json");
  add_terrain(*verb, flags->flight.terrain);
  verb->add_option("--methods", flags->methods, "all, or names separated by commas")
      ->capture_default_str();
  add_flight(*verb, flags->flight);
  add_frames(*verb, flags->flight.frames);
  add_missing(*verb, flags->flight);
  add_choice<Io>(
      *verb, "--io", flags->flight.terrain.io, {{"read", Io::Read}, {"mmap", Io::Map}},
      "How the store's files are read: read (pread), or mmap (copied out of a mapping: to "
      "compare, for a file that shrinks meanwhile ends the program) [read]")
      ->type_name("HOW");
  verb->add_flag_callback(
      "--no-draw", [flags] { flags->drawing = Drawing::Skip; }, "Time the refinement alone");
  verb->add_option("--paper", flags->paper, "Repeat a paper's own experiment: smart")
      ->type_name("NAME");
  verb->add_option("--report", flags->report, "A page with a table and charts")->type_name("HTML");
  verb->add_flag("--json", flags->json, "Print JSON");
  add_quiet(*verb, flags->flight.terrain.talk);
  verb->callback([flags] { run(*flags); });
}

}  // namespace arete::app
