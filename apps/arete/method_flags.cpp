#include "method_flags.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "arete/core/error.h"

namespace arete::app {
namespace {

constexpr std::array<std::string_view, 4> kPatchMethods{"full", "geomipmap", "smooth", "deboer"};
constexpr std::array<std::string_view, 2> kPageMethods{"soar", "smart"};
constexpr std::array<std::pair<std::string_view, ErrorScale>, 3> kScales{{
    {"up", ErrorScale::Upright},
    {"ang", ErrorScale::Angular},
    {"rig", ErrorScale::Rigorous},
}};

std::vector<std::string_view> split(std::string_view list) {
  std::vector<std::string_view> words;
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    words.push_back(list.substr(0, comma));
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
  return words;
}

}  // namespace

lod::Params params_of(const MethodFlags& flags, std::string_view method) {
  lod::Params params;
  if (!flags.patch.empty() && std::ranges::count(kPatchMethods, method) != 0) {
    params["patch"] = flags.patch;
  }
  for (const std::string& setting : flags.settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw Error(ErrorCode::Usage, fmt::format("--set {}: not NAME=VALUE: write --set patch=65 "
                                                "or --set geomipmap.patch=65",
                                                setting));
    }
    std::string name = setting.substr(0, equals);
    if (const std::size_t dot = name.find('.'); dot != std::string::npos) {
      if (name.substr(0, dot) != method) {
        continue;
      }
      name.erase(0, dot + 1);
    }
    params[name] = setting.substr(equals + 1);
  }
  return params;
}

bool has_pages(std::string_view method) {
  return std::ranges::count(kPageMethods, method) != 0;
}

std::vector<std::string> method_list(std::string_view names) {
  const std::vector<std::string_view> wanted = split(names);
  for (const std::string_view name : wanted) {
    if (name != "all") {
      lod::find_engine(name);  // throws when there is none
    }
  }
  std::vector<std::string> methods;
  for (const lod::EngineInfo& engine : lod::engines()) {
    if (std::ranges::count(wanted, "all") != 0 || std::ranges::count(wanted, engine.name) != 0) {
      methods.emplace_back(engine.name);
    }
  }
  if (methods.empty()) {
    throw Error(ErrorCode::Usage, "--methods: names no method: write all or a list");
  }
  return methods;
}

ErrorScale error_scale(std::string_view name) {
  const auto* const row =
      std::ranges::find(kScales, name, &std::pair<std::string_view, ErrorScale>::first);
  if (row == kScales.end()) {
    throw Error(ErrorCode::Usage, fmt::format("--scale {}: unknown: use up, ang or rig", name));
  }
  return row->second;
}

std::string_view scale_name(ErrorScale scale) {
  return std::ranges::find(kScales, scale, &std::pair<std::string_view, ErrorScale>::second)->first;
}

}  // namespace arete::app
