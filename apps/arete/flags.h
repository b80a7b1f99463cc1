#pragma once

#include <cstdint>
#include <map>
#include <string>

#include <CLI/CLI.hpp>

#include "arete/lod/engine.h"
#include "arete/scene/path.h"

#include "open_store.h"
#include "quantities.h"

namespace arete::app {

/// What render, verify, bench and view share.
struct FlightFlags {
  TerrainFlags terrain;
  std::string path = "flyover";
  int frames = 300;
  FrameSize size;
  Tolerance tolerance;
  std::string scale = "up";
  Bytes gpu_memory{std::size_t{1} << 30U};
  std::uint64_t triangles = lod::Budget::kUnlimited;
  lod::OnMissing on_missing = lod::OnMissing::Wait;

  /// Without the budget: see budget_of.
  lod::RefineOptions refine_options() const;
};

/// A new verb with its example at the end of --help.
CLI::App* add_verb(CLI::App& app, const std::string& name, const std::string& summary,
                   const std::string& example);

/// A flag whose value is one of a few names.
template <typename Value>
CLI::Option* add_choice(CLI::App& verb, const std::string& name, Value& value,
                        const std::map<std::string, Value>& choices, const std::string& help) {
  const auto choose = [&value, choices, name](const std::string& word) {
    const auto found = choices.find(word);
    if (found == choices.end()) {
      std::string names;
      for (const auto& choice : choices) {
        names += (names.empty() ? "" : ", ") + choice.first;
      }
      throw CLI::ValidationError(name, word + " is not one of " + names);
    }
    value = found->second;
  };
  return verb.add_option_function<std::string>(name, choose, help);
}

/// A flag whose value is a quantity.
template <typename Quantity>
CLI::Option* add_quantity(CLI::App& verb, const std::string& name, Quantity& quantity,
                          const std::string& help) {
  const auto read = [&quantity, name](const std::string& word) {
    if (!parse(word, quantity)) {
      throw CLI::ConversionError(word, name);
    }
  };
  return verb.add_option_function<std::string>(name, read, help);
}

void add_terrain(CLI::App& verb, TerrainFlags& flags);
void add_method(CLI::App& verb, std::string& method);
void add_settings(CLI::App& verb, MethodFlags& flags);
void add_quiet(CLI::App& verb, Talk& talk);
/// --path --size --tolerance --scale, the settings of methods and the budgets.
void add_flight(CLI::App& verb, FlightFlags& flags);
void add_frames(CLI::App& verb, int& frames);
void add_cache(CLI::App& verb, Bytes& cache);
/// --on-missing --no-prefetch: for measuring what prefetching does.
void add_missing(CLI::App& verb, FlightFlags& flags);

/// The i-th of n instants of a path, in seconds: the path's n equal parts begin at them, as in
/// proof::verify.
double instant(const scene::Path& path, int i, int n);

}  // namespace arete::app
