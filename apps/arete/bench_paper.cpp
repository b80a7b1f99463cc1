#include "bench_paper.h"

#include <optional>
#include <vector>

#include <fmt/format.h>

#include "arete/proof/papers/paper.h"

#include "ground.h"
#include "interrupt.h"
#include "json.h"

namespace arete::app {
namespace {

Json number_or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json json_of(const proof::PaperRow& r) {
  return {{"table", r.table},
          {"quantity", r.quantity},
          {"setting", r.setting},
          {"published", number_or_null(r.published)},
          {"measured", number_or_null(r.measured)},
          {"unit", r.unit},
          {"note", r.note}};
}

std::string number_text(const std::optional<double>& value) {
  return value ? fmt::format("{:.4g}", *value) : "-";
}

void print_table(const std::vector<proof::PaperRow>& rows) {
  std::string setting;
  for (const proof::PaperRow& r : rows) {
    if (r.setting != setting) {
      setting = r.setting;
      fmt::print("\n{}\n{:<40}{:>12}{:>12} {}\n", setting, "", "published", "measured", "unit");
    }
    fmt::print("{:<40}{:>12}{:>12} {:<4}{}\n", r.quantity, number_text(r.published),
               number_text(r.measured), r.unit, r.note.empty() ? "" : "  " + r.note);
  }
}

}  // namespace

void bench_paper(const FlightFlags& flags, const std::string& name, Format format) {
  const proof::Paper& paper = proof::find_paper(name);
  const std::vector<std::string> methods(paper.methods.begin(), paper.methods.end());
  const auto terrain = open_terrain(flags.terrain, methods);
  const scene::Path path = scene::make_path(flags.path, ground_of(*terrain, store::Fetch::Wait));
  ProgressBar bar(flags.terrain.talk);
  const std::string file = flags.terrain.terrain.string();
  const std::vector<proof::PaperRow> rows =
      paper.run(*terrain, path, {flags.frames, [&](std::string_view what, double done) {
                                   stop_if_interrupted(file);
                                   bar.show(what, done);
                                 }});
  bar.clear();
  tell_of_damage(*terrain, flags.terrain);
  if (format == Format::Text) return print_table(rows);
  Json json = Json::array();
  for (const proof::PaperRow& row : rows) json.push_back(json_of(row));
  print_json(
      {{"paper", paper.name}, {"terrain", file}, {"machine", machine_json("")}, {"rows", json}});
}

}  // namespace arete::app
