#include "arete/lod/geomipmap/geomipmap.h"
#include "arete/lod/geomipmap/literal.h"
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

}  // namespace

std::unique_ptr<Engine> open(const store::Terrain& terrain, const Params& params) {
  check_names(params, {"patch", "topology", "literal"});
  if (flag_param(params, "literal")) return open_literal(terrain, params);
  const int w = parse_patch(param(params, "patch", "auto"), terrain.manifest());
  return std::make_unique<GeomipmapEngine>(terrain, w, topology_param(params, Topology::Triangles));
}

}  // namespace arete::lod::geomipmap
