#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "arete/lod/engine.h"

#include "lod/built_terrain.h"

namespace arete::lod {

/// A method as the common tests open it.
struct Variant {
  std::string name;
  std::string_view method;
  Params params;

  std::unique_ptr<Engine> open(const store::Terrain& terrain, std::string_view patch) const {
    Params all = params;
    all["patch"] = patch;
    return find_engine(method).open(terrain, params_for(method, all));
  }
};

/// Every row of engines.cpp as it is by default, and the options that draw another surface.
inline std::vector<Variant> variants() {
  std::vector<Variant> out;
  for (const EngineInfo& engine : engines())
    out.push_back({std::string(engine.name), engine.name, {}});
  out.push_back({"geomipmap_literal", "geomipmap", {{"literal", "true"}}});
  out.push_back({"deboer_trilinear", "deboer", {{"trilinear", "true"}}});
  return out;
}

inline void PrintTo(const Variant& variant, std::ostream* out) {
  *out << variant.name;
}

}  // namespace arete::lod
