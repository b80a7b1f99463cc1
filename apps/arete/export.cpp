#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/mesh/write.h"
#include "arete/proof/residual.h"

#include "flags.h"
#include "json.h"
#include "verbs.h"
#include "whole_surface.h"

namespace arete::app {
namespace {

struct ExportFlags {
  TerrainFlags terrain;
  std::string method = "geomipmap";
  std::filesystem::path output;
  double max_error_m = 1;
  bool json = false;
};

/// What is measured at every sample, by the proof's own reading of the surface.
struct ExportReport {
  std::uint64_t triangles = 0, vertices = 0, samples = 0;
  double max_error_m = 0, sum_of_squares = 0;
  bool watertight = false;
  double rmse_m() const {
    return samples == 0 ? 0 : std::sqrt(sum_of_squares / static_cast<double>(samples));
  }
};

ExportReport measure(const mesh::Surface& surface, const Heightfield& dem) {
  ExportReport report;
  const proof::Reference reference(dem, default_threads());
  proof::for_each_residual(surface, reference, [&](const proof::PostResidual& r) {
    const double error = std::abs(r.drawn_z - r.true_z);
    report.max_error_m = std::max(report.max_error_m, error);
    report.sum_of_squares += error * error;
    ++report.samples;
  });
  const mesh::SurfaceReport check = mesh::check_surface(surface, dem, nullptr, default_threads());
  report.watertight = check.cracks() == 0 && check.t_junctions == 0;
  return report;
}

void print_report(const ExportFlags& flags, const ExportReport& r, double seconds) {
  if (flags.json) {
    print_json({{"method", flags.method},
                {"triangles", r.triangles},
                {"vertices", r.vertices},
                {"max_error_m", r.max_error_m},
                {"rmse_m", r.rmse_m()},
                {"seconds", seconds},
                {"watertight", r.watertight}});
  } else if (flags.terrain.talk == Talk::Normal) {
    fmt::print("{}: {} triangles, error {:.4g} m at most, {:.4g} m rms over {} samples{}\n",
               flags.output.string(), grouped(r.triangles), r.max_error_m, r.rmse_m(),
               grouped(r.samples), r.watertight ? ", watertight" : "");
  }
}

void run(const ExportFlags& flags) {
  const auto start = std::chrono::steady_clock::now();
  mesh::check_mesh_name(flags.output);  // before the work
  const auto terrain = open_terrain(flags.terrain, {flags.method});
  const auto engine = open_method(flags.terrain, flags.method, *terrain);
  const Heightfield dem(*terrain->height_source());
  const mesh::Surface surface = whole_surface(*engine, terrain->manifest(), flags.max_error_m);
  ExportReport report = measure(surface, dem);
  const mesh::MeshSize written = mesh::write_mesh(
      flags.output, surface,
      {dem.georef().world_from_post,
       [&](const std::array<Post, 3>& corners) { return touches_drawable_cell(corners, dem); }});
  report.triangles = written.triangles;
  report.vertices = written.vertices;
  print_report(flags, report,
               std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

}  // namespace

void add_export(CLI::App& app) {
  auto flags = std::make_shared<ExportFlags>();
  CLI::App* const verb = add_verb(app, "export", "Write the terrain as a mesh with a bounded error",
                                  "arete export alps.arete -o alps.glb --max-error 2");
  add_terrain(*verb, flags->terrain);
  verb->add_option("-o,--output", flags->output, "mesh.glb, .obj, .ply or .stl")->required();
  add_method(*verb, flags->method);
  verb->add_option("--max-error", flags->max_error_m, "Largest vertical error, metres")
      ->capture_default_str()
      ->check(CLI::PositiveNumber)
      ->type_name("METRES");
  add_settings(*verb, flags->terrain.method_flags);
  add_cache(*verb, flags->terrain.cache);
  verb->add_flag("--json", flags->json, "Print JSON");
  add_quiet(*verb, flags->terrain.talk);
  verb->callback([flags] { run(*flags); });
}

}  // namespace arete::app
