#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/lod/geomipmap/geomipmap.h"
#include "arete/lod/params.h"
#include "arete/lod/patch_drawer.h"

namespace arete::lod::geomipmap {
namespace {

class GeomipmapEngine final : public LevelFieldEngine {
 public:
  using LevelFieldEngine::LevelFieldEngine;

  Claims claims(const RefineOptions& options) const override {
    return field_claims(options, options.tolerance_px);
  }
};

Topology parse_topology(std::string_view text) {
  if (text == "list") return Topology::Triangles;
  if (text == "strip") return Topology::Strip;
  throw Error(ErrorCode::Usage, fmt::format("topology={}: unknown: use list or strip", text));
}

}  // namespace

std::unique_ptr<Engine> open(const store::Terrain& terrain, const Params& params) {
  check_names(params, {"patch", "topology"});
  const int w = parse_patch(param(params, "patch", "auto"), terrain.manifest());
  return std::make_unique<GeomipmapEngine>(terrain, w,
                                           parse_topology(param(params, "topology", "list")));
}

}  // namespace arete::lod::geomipmap
