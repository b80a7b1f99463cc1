#include "arete/proof/verify.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/core/heightfield.h"

#include "budgets.h"
#include "flags.h"
#include "ground.h"
#include "interrupt.h"
#include "json.h"
#include "verbs.h"

namespace arete::app {
namespace {

struct VerifyFlags {
  FlightFlags flight;
  std::string method;
  std::filesystem::path dump;
  bool json = false;
};

Json json_of(const VerifyFlags& flags, const proof::VerifyReport& r) {
  return {{"method", flags.method},
          {"options", options_json(flags.flight, flags.method)},
          {"claims",
           {{"conforming", r.claims.conforming},
            {"error_px", finite(r.claims.error_px)},
            {"pop_px", finite(r.claims.pop_px)},
            {"error_angular_px", finite(r.claims.error_angular_px)}}},
          {"holds", r.holds()},
          {"frames", r.frames},
          {"tolerance_px", r.tolerance_px},
          {"max_error_px", finite(r.max_error_px)},
          {"p999_error_px", finite(r.p999_error_px)},
          {"max_error_angular_px", finite(r.max_error_angular_px)},
          {"cracks", r.cracks},
          {"t_junctions", r.t_junctions},
          {"background_pixels", r.background_pixels},
          {"max_pop_px", finite(r.max_pop_px)},
          {"p999_pop_px", finite(r.p999_pop_px)},
          {"max_pop_share", finite(r.max_pop_share)},
          {"unpromised_pairs", r.unpromised_pairs},
          {"undrawn_posts", r.undrawn_posts},
          {"mean_triangles", r.mean_triangles},
          {"max_triangles", r.max_triangles},
          {"max_vertex_bytes", r.max_vertex_bytes},
          {"over_budget_frames", r.over_budget_frames},
          {"broken_bounds", r.broken_bounds},
          {"max_tolerance_px", finite(r.max_tolerance_px)},
          {"achieved_error_px", finite(r.achieved_error_px)},
          {"seconds", r.seconds}};
}

std::string promise(double limit, const char* unit) {
  return std::isfinite(limit) ? fmt::format("promised {:.4g} {}", limit, unit) : "not promised";
}

void print_table(const VerifyFlags& flags, const proof::VerifyReport& r) {
  fmt::print("{} on {}: {} frames, tolerance {:.4g} px, {:.1f} s\n", flags.method,
             flags.flight.terrain.terrain.string(), r.frames, r.tolerance_px, r.seconds);
  fmt::print("  error       {:10.4f} px at most, {:.4f} for 99.9 % ({})\n", r.max_error_px,
             r.p999_error_px, promise(r.claims.error_px, "px"));
  fmt::print("  as an angle {:10.4f} px at most\n", r.max_error_angular_px);
  fmt::print("  bound       {:10.4f} px by the method's own account{}\n", r.achieved_error_px,
             r.max_tolerance_px > r.tolerance_px
                 ? fmt::format(", the budgets asking for {:.4g} px", r.max_tolerance_px)
                 : "");
  fmt::print("  cracks      {:10}    T-junctions {} ({})\n", r.cracks, r.t_junctions,
             r.claims.conforming ? "promised none" : "not promised");
  fmt::print("  background  {:10} pixels seen through the surface, {} posts not drawn\n",
             r.background_pixels, r.undrawn_posts);
  fmt::print("  pops        {:10.4f} px at most, {:.4f} for 99.9 % ({}{})\n", r.max_pop_px,
             r.p999_pop_px, promise(r.claims.pop_px, "px x relative motion"),
             std::isfinite(r.claims.pop_px)
                 ? fmt::format(", {:.0f} % of it at worst", 100 * r.max_pop_share)
                 : "");
  fmt::print("  triangles   {:>10} on average, {} at most, in {} of vertices\n",
             grouped(static_cast<unsigned long long>(r.mean_triangles)), grouped(r.max_triangles),
             bytes_text(static_cast<double>(r.max_vertex_bytes)));
  fmt::print("  budgets     {:>10}\n",
             r.over_budget_frames == 0 ? "kept"
                                       : fmt::format("broken in {} frames", r.over_budget_frames));
  fmt::print("  {}\n", r.holds() ? "every claim holds" : "A CLAIM IS BROKEN");
}

proof::VerifyReport measure(const VerifyFlags& flags) {
  const auto terrain = open_terrain(flags.flight.terrain, {flags.method});
  const auto engine = open_method(flags.flight.terrain, flags.method, *terrain);
  const scene::Path path =
      scene::make_path(flags.flight.path, ground_of(*terrain, store::Fetch::Wait));
  const Heightfield dem(*terrain->height_source());
  ProgressBar bar(flags.flight.terrain.talk);
  proof::VerifyOptions options;
  options.frames = flags.flight.frames;
  options.width = flags.flight.size.width;
  options.height = flags.flight.size.height;
  options.threads = default_threads();
  options.refine = flags.flight.refine_options();
  options.refine.budget = budget_of(flags.flight, flags.method, *terrain, *engine, nullptr);
  options.gpu_memory = renderer_memory(flags.flight);
  if (!flags.dump.empty()) {
    options.dump = flags.dump;
  }
  options.progress = [&](double done) {
    stop_if_interrupted(flags.flight.terrain.terrain.string());
    bar.show("verifying", done);
  };
  const proof::VerifyReport report = proof::verify(*engine, dem, path, options);
  bar.clear();
  tell_of_damage(*terrain, flags.flight.terrain);
  return report;
}

void run(const VerifyFlags& flags) {
  const proof::VerifyReport report = measure(flags);
  if (flags.json) {
    print_json(json_of(flags, report));
  } else {
    print_table(flags, report);
  }
  if (!report.holds()) {
    std::fflush(stdout);
    throw Error(ErrorCode::InvalidInput,
                fmt::format("{}: {} breaks a claim: see the report",
                            flags.flight.terrain.terrain.string(), flags.method));
  }
}

}  // namespace

void add_verify(CLI::App& app) {
  auto flags = std::make_shared<VerifyFlags>();
  CLI::App* const verb = add_verb(app, "verify", "Measure every frame against the method's claims",
                                  "arete verify alps.arete --method geomipmap --frames 60 --json");
  add_terrain(*verb, flags->flight.terrain);
  verb->add_option("--method", flags->method, "Level-of-detail method")->required();
  add_flight(*verb, flags->flight);
  add_frames(*verb, flags->flight.frames);
  verb->add_option("--dump", flags->dump, "Each frame's surface as PLY and its camera as JSON")
      ->type_name("DIR");
  verb->add_flag("--json", flags->json, "Print JSON");
  add_quiet(*verb, flags->flight.terrain.talk);
  verb->callback([flags] { run(*flags); });
}

}  // namespace arete::app
