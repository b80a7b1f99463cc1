#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "flags.h"
#include "interrupt.h"
#include "json.h"
#include "verbs.h"

namespace arete::app {
namespace {

struct InfoFlags {
  TerrainFlags terrain;
  bool json = false;
  bool check = false;
};

std::uint64_t store_bytes(const store::Manifest& m) {
  std::uint64_t bytes = 0;
  for (const store::SegmentRecord& segment : m.segments) {
    bytes += segment.bytes;
  }
  return bytes;
}

Json json_of(const store::Manifest& m) {
  Json segments = Json::array();
  for (const store::SegmentRecord& segment : m.segments) {
    segments.push_back({{"name", segment.name}, {"id", segment.id}, {"bytes", segment.bytes}});
  }
  return {{"format_version", m.format_version},
          {"id", m.id},
          {"cols", m.cols},
          {"rows", m.rows},
          {"world_from_post", m.georef.world_from_post.m},
          {"z_min", m.z_min},
          {"z_max", m.z_max},
          {"quantum", m.quantum_m},
          {"max_store_error_m", m.max_store_error_m},
          {"nodata_share", m.nodata_share},
          {"crs", m.georef.crs_name},
          {"source", m.source},
          {"methods", m.methods},
          {"bytes", store_bytes(m)},
          {"segments", segments}};
}

void print_table(const store::Manifest& m) {
  const auto& a = m.georef.world_from_post.m;
  const glm::dvec2 spacing{std::hypot(a[0], a[3]), std::hypot(a[1], a[4])};
  fmt::print("source     {}\n", m.source);
  fmt::print("posts      {} x {}, {:.6g} x {:.6g} m apart ({:.4g} x {:.4g} km)\n", m.cols, m.rows,
             spacing.x, spacing.y, (m.cols - 1) * spacing.x / 1000,
             (m.rows - 1) * spacing.y / 1000);
  fmt::print("heights    {:.6g} to {:.6g} m, kept in steps of {:.6g} m (largest error {:.3g} m)\n",
             m.z_min, m.z_max, m.quantum_m, m.max_store_error_m);
  fmt::print("no data    {:.2f} % of the posts; {} drawable cells\n", 100 * m.nodata_share,
             grouped(m.drawable_cells));
  fmt::print("crs        {}\n", m.georef.crs_name.empty() ? "none named" : m.georef.crs_name);
  fmt::print("methods    {}\n", fmt::join(m.methods, " "));
  fmt::print("id         {} (format {})\n", m.id, m.format_version);
  fmt::print("bytes      {} in {} segments\n", bytes_text(static_cast<double>(store_bytes(m))),
             m.segments.size());
  for (const store::SegmentRecord& segment : m.segments) {
    fmt::print("  {:<20} {:>12}\n", segment.name, bytes_text(static_cast<double>(segment.bytes)));
  }
  for (const std::string& note : m.georef.notes) {
    fmt::print("note: {}\n", note);
  }
}

std::uint64_t check_pages(const store::Terrain& terrain, const TerrainFlags& flags) {
  ProgressBar bar(flags.talk);
  return terrain.check_all([&](double done) {
    stop_if_interrupted(flags.terrain.string());
    bar.show("verifying pages", done);
  });
}

void run(const InfoFlags& flags) {
  const auto terrain = open_terrain(flags.terrain, {});
  Json json = json_of(terrain->manifest());
  if (!flags.json) {
    print_table(terrain->manifest());
  }
  if (flags.check) {
    const std::uint64_t pages = check_pages(*terrain, flags.terrain);
    json["checked_pages"] = pages;
    if (!flags.json) {
      fmt::print("checked    {} pages, all as written\n", grouped(pages));
    }
  }
  if (flags.json) {
    print_json(json);
  }
}

}  // namespace

void add_info(CLI::App& app) {
  auto flags = std::make_shared<InfoFlags>();
  CLI::App* const verb =
      add_verb(app, "info", "Say what a store holds", "arete info alps.arete --check");
  add_terrain(*verb, flags->terrain);
  verb->add_flag("--json", flags->json, "Print JSON");
  verb->add_flag("--check", flags->check, "Read and verify every page");
  add_quiet(*verb, flags->terrain.talk);
  verb->callback([flags] { run(*flags); });
}

}  // namespace arete::app
