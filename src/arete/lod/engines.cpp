#include <array>
#include <string>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/lod/bintree/bintree.h"
#include "arete/lod/bintree/smart.h"
#include "arete/lod/bintree/soar.h"
#include "arete/lod/deboer/deboer.h"
#include "arete/lod/engine.h"
#include "arete/lod/full/full.h"
#include "arete/lod/geomipmap/geomipmap.h"

namespace arete::lod {

std::span<const EngineInfo> engines() {
  static constexpr std::array<EngineInfo, 5> kEngines{{
      {"full", "", "every post, every triangle: the reference", full::preprocess, full::open},
      {"geomipmap", "Wagner2003", "square patches, continuous levels, nine-factor geomorph",
       geomipmap::preprocess, geomipmap::open},
      {"deboer", "deBoer2000",
       "square blocks, levels by distance, sides of any difference, no morph", deboer::preprocess,
       deboer::open},
      {"soar", "LindstromPascucci2002", "bin-tree refined from the top every frame, one strip",
       bintree::preprocess, bintree::open_soar},
      {"smart", "BaoPajarolaShafae2004", "the triangles of soar, statuses kept in live ranges",
       bintree::preprocess, bintree::open_smart},
  }};
  return kEngines;
}

void require_room(const Footprint& footprint, const Budget& budget, std::string_view terrain) {
  if (budget.triangles < footprint.least.triangles) {
    throw Error(ErrorCode::Limit,
                fmt::format("{}: --triangles {}: the coarsest surface has {} triangles: allow at "
                            "least that many",
                            terrain, budget.triangles, footprint.least.triangles));
  }
  if (budget.vertex_bytes < footprint.least.vertex_bytes) {
    throw Error(ErrorCode::Limit,
                fmt::format("{}: {} bytes for vertices: the coarsest surface takes {}: allow at "
                            "least that many",
                            terrain, budget.vertex_bytes, footprint.least.vertex_bytes));
  }
}

const EngineInfo& find_engine(std::string_view name) {
  std::string names;
  for (const EngineInfo& info : engines()) {
    if (info.name == name) return info;
    names += (names.empty() ? "" : ", ") + std::string(info.name);
  }
  throw Error(ErrorCode::Usage, fmt::format("{}: no such method: use one of {}", name, names));
}

}  // namespace arete::lod
