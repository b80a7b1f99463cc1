#include <limits>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/lod/geomipmap/geomipmap.h"
#include "arete/lod/params.h"
#include "arete/lod/patch_drawer.h"

namespace arete::lod::geomipmap {
namespace {

class GeomipmapEngine final : public PatchEngine {
 public:
  using PatchEngine::PatchEngine;

  // "All tessellation levels are calculated first, without creating the resulting geometry, and
  // then each patch is informed about its neighbours' levels" [Wagner2003, "Connecting Patches"].
  void refine(const View& view, const RefineOptions& options, DrawList& out) override {
    out.clear();
    const ScreenError error(view, options.tolerance_px, options.scale);
    drawer_.field().solve(view.eye, error);
    out.stats.evaluated_vertices = static_cast<std::uint64_t>(drawer_.table().size());
    drawer_.draw(view, options, error, out);
  }

  Claims claims(const RefineOptions& options) const override {
    // An angle is not a distance in the image: under Angular the bound holds on a sphere only.
    const bool in_pixels = options.scale != ErrorScale::Angular;
    // 2 tau kappa / (kappa - 1) |dP| / D  [METHODS 7.8(9)]
    const double motion = 2 * options.tolerance_px * LevelField::kKappa / (LevelField::kKappa - 1);
    const double none = std::numeric_limits<double>::infinity();
    return {.conforming = true,
            .error_px = in_pixels ? options.tolerance_px : none,
            .pop_px = motion,
            .error_angular_px = in_pixels ? none : options.tolerance_px};
  }
};

Topology parse_topology(std::string_view text) {
  if (text == "list") return Topology::Triangles;
  if (text == "strip") return Topology::Strip;
  throw Error(ErrorCode::Usage, fmt::format("topology={}: unknown: use list or strip", text));
}

}  // namespace

std::unique_ptr<Engine> open(const store::Terrain& terrain, const Params& params) {
  check_names(params, {"patch", "topology", "blocks"});
  const int w = parse_patch(param(params, "patch", "auto"), terrain.manifest());
  const auto mib = static_cast<std::size_t>(int_param(params, "blocks", 256, {1, 1 << 20}));
  return std::make_unique<GeomipmapEngine>(
      terrain, w, parse_topology(param(params, "topology", "list")), mib << 20U);
}

}  // namespace arete::lod::geomipmap
