#include "flags.h"

#include <limits>

namespace arete::app {

lod::RefineOptions FlightFlags::refine_options() const {
  lod::RefineOptions options;
  options.tolerance_px = tolerance.pixels(size.height);
  options.scale = error_scale(scale);
  options.on_missing = on_missing;
  return options;
}

CLI::App* add_verb(CLI::App& app, const std::string& name, const std::string& summary,
                   const std::string& example) {
  CLI::App* const verb = app.add_subcommand(name, summary);
  verb->footer("\nExample:\n  " + example);
  return verb;
}

void add_terrain(CLI::App& verb, TerrainFlags& flags) {
  verb.add_option("STORE", flags.terrain, "A .arete store, or a DEM file")->required();
}

void add_method(CLI::App& verb, std::string& method) {
  verb.add_option("--method", method, "Level-of-detail method")->capture_default_str();
}

void add_settings(CLI::App& verb, MethodFlags& flags) {
  verb.add_option("--patch", flags.patch, "Posts a side of a patch of the tile methods")
      ->check(CLI::IsMember({"auto", "9", "17", "33", "65", "129"}));
  verb.add_option("--set", flags.settings,
                  "NAME=VALUE for the method, or METHOD.NAME=VALUE; may be repeated")
      ->type_name("NAME=VALUE")
      ->expected(1)
      ->take_all();
}

void add_quiet(CLI::App& verb, Talk& talk) {
  verb.add_flag_callback(
      "--quiet", [&talk] { talk = Talk::Quiet; }, "No notes, no progress");
}

void add_flight(CLI::App& verb, FlightFlags& flags) {
  verb.add_option("--path", flags.path, "flyover, orbit, descent or a JSON file")
      ->capture_default_str();
  add_quantity(verb, "--size", flags.size, "Pixels [1280x720]")->type_name("WxH");
  add_quantity(verb, "--tolerance", flags.tolerance,
               "Largest screen error in pixels, or in % of the height [1]")
      ->type_name("PX|P%");
  verb.add_option("--scale", flags.scale,
                  "How metres become pixels: up (rigorous, camera without roll), rig (rigorous for "
                  "any shift), ang (as an angle: the papers' notion, no bound in pixels)")
      ->capture_default_str()
      ->check(CLI::IsMember({"up", "rig", "ang"}));
  add_settings(verb, flags.terrain.method_flags);
  // After --set, whose values replace what is there.
  verb.add_flag_callback(
      "--literal", [&flags] { flags.terrain.method_flags.settings.emplace_back("literal=true"); },
      "The method as its paper has it, with what that cannot keep (as --set literal=true)");
  add_cache(verb, flags.terrain.cache);
  add_quantity(verb, "--gpu-memory", flags.gpu_memory, "Most bytes on the GPU [1G]")
      ->type_name("BYTES");
  verb.add_option("--triangles", flags.triangles, "Most triangles in a frame [no limit]")
      ->type_name("N");
}

void add_frames(CLI::App& verb, int& frames) {
  verb.add_option("--frames", frames, "Instants of the path, evenly spaced")
      ->capture_default_str()
      ->check(CLI::Range(1, 1'000'000));
}

void add_cache(CLI::App& verb, Bytes& cache) {
  add_quantity(verb, "--cache", cache, "Most bytes of terrain in memory [512M]")
      ->type_name("BYTES");
}

void add_missing(CLI::App& verb, FlightFlags& flags) {
  add_choice<lod::OnMissing>(verb, "--on-missing", flags.on_missing,
                             {{"wait", lod::OnMissing::Wait}, {"defer", lod::OnMissing::Defer}},
                             "Tiles that are not in memory: wait (read them now), or defer (draw "
                             "coarser meanwhile) [wait]")
      ->type_name("WHAT");
  verb.add_flag_callback(
      "--no-prefetch", [&flags] { flags.terrain.prefetch = false; },
      "Load no tile in the background, read no record page before a frame misses it");
}

double instant(const scene::Path& path, int i, int n) {
  return path.duration() * i / n;
}

}  // namespace arete::app
