#include "arete/lod/full/full.h"

#include "arete/lod/params.h"
#include "arete/lod/patch_drawer.h"

namespace arete::lod::full {
namespace {

class FullEngine final : public LevelFieldEngine {
 public:
  using LevelFieldEngine::LevelFieldEngine;

  // Level 0 everywhere is the reference itself: no error, no motion. Under a budget it is drawn as
  // any patch method would (RefineStats::tolerance_px > 0), and so are its claims.
  Claims claims(const RefineOptions& options) const override {
    return field_claims(options, options.budget == Budget{} ? 0 : options.tolerance_px);
  }

 protected:
  double finest_px(const RefineOptions&) const override { return 0; }
};

}  // namespace

void preprocess(const store::Terrain& terrain, store::Writers& writers, const BuildContext&,
                const Params& params) {
  write_patch_table(terrain, writers,
                    parse_patch(param(params, "patch", "auto"), terrain.manifest()));
}

std::unique_ptr<Engine> open(const store::Terrain& terrain, const Params& params) {
  check_names(params, {"patch"});
  const int w = parse_patch(param(params, "patch", "auto"), terrain.manifest());
  return std::make_unique<FullEngine>(terrain, w, Topology::Triangles);
}

}  // namespace arete::lod::full
