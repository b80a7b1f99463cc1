#include "arete/lod/full/full.h"

#include "arete/lod/params.h"
#include "arete/lod/patch_drawer.h"

namespace arete::lod::full {
namespace {

class FullEngine final : public PatchEngine {
 public:
  using PatchEngine::PatchEngine;

  void refine(const View& view, const RefineOptions& options, DrawList& out) override {
    out.clear();
    drawer_.field().solve_full(view.eye);
    drawer_.draw(view, options, ScreenError(view, options.tolerance_px, options.scale), out);
  }
  // Level 0 everywhere is the reference itself: no error, no motion.
  Claims claims(const RefineOptions&) const override {
    return {.conforming = true, .error_px = 0, .pop_px = 0, .error_angular_px = 0};
  }
};

}  // namespace

void preprocess(const store::Terrain& terrain, store::Writers& writers, const BuildContext&,
                const Params& params) {
  write_patch_table(terrain, writers,
                    parse_patch(param(params, "patch", "auto"), terrain.manifest()));
}

std::unique_ptr<Engine> open(const store::Terrain& terrain, const Params& params) {
  check_names(params, {"patch", "blocks"});
  const int w = parse_patch(param(params, "patch", "auto"), terrain.manifest());
  const auto mib = static_cast<std::size_t>(int_param(params, "blocks", 1024, {1, 1 << 20}));
  return std::make_unique<FullEngine>(terrain, w, Topology::Triangles, mib << 20U);
}

}  // namespace arete::lod::full
