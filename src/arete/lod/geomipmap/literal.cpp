#include "arete/lod/geomipmap/literal.h"

#include <algorithm>
#include <cmath>

#include "arete/lod/params.h"
#include "arete/lod/uniform_engine.h"

namespace arete::lod::geomipmap {
namespace {

// Pixels between a post and where a mesh has it. A vertex of smaller error but nearer may project
// larger: no bound.
class Projector {
 public:
  Projector(const View& view, const Affine2& world_from_post)
      : view_(view), world_from_post_(world_from_post) {}

  // Deviation: a vertex behind the camera has no image; there its error is f delta / D, D its own
  // distance.
  double pixels(const MaxErrorVertex& v) const {
    const glm::dvec2 plan = world_from_post_.apply(v.post.col, v.post.row);
    const glm::dvec3 there(plan, v.z);
    const glm::dvec3 true_px = project(view_, there);
    const glm::dvec3 drawn_px = project(view_, {plan, v.drawn_z});
    if (true_px.z > view_.near_m && drawn_px.z > view_.near_m)
      return glm::length(glm::dvec2(true_px) - glm::dvec2(drawn_px));
    const double distance = std::max(glm::length(view_.eye - there), view_.near_m);
    return view_.focal_px() * std::abs(double{v.drawn_z} - double{v.z}) / distance;
  }

 private:
  const View& view_;
  const Affine2& world_from_post_;
};

class LiteralEngine final : public UniformEngine {
 public:
  LiteralEngine(const store::Terrain& terrain, int log2_cells, Topology topology)
      : UniformEngine(terrain, log2_cells,
                      std::make_unique<UniformMesh>(topology, UniformMesh::Towards::Drawn),
                      UniformField::Sides::Coarser),
        world_from_post_(terrain.manifest().georef.world_from_post) {}

 protected:
  // "All saved maxerror vertices are projected into the scene and the resulting errors calculated.
  // Finally the level with the largest error below an application defined error bound is chosen"
  // [Wagner2003].
  std::uint64_t set_levels(const View& view, const ScreenError&, double tolerance_px) override {
    field().look_from(view.eye);
    const Projector projector(view, world_from_post_);
    std::uint64_t projected = 0;
    for (int p = 0; p < drawer_.table().size(); ++p) {
      if (!drawer_.table().drawable(p)) continue;
      const auto error_of = [&](int level) {
        ++projected;
        return projector.pixels(table().at(p, level));
      };
      field().set_level(p, coarsest_level(drawer_.table().log2_cells(), tolerance_px, error_of));
    }
    return projected;
  }

 private:
  Affine2 world_from_post_;
};

}  // namespace

std::unique_ptr<Engine> open_literal(const store::Terrain& terrain, const Params& params) {
  const int w = parse_uniform_patch(param(params, "patch", "auto"), terrain.manifest());
  return std::make_unique<LiteralEngine>(terrain, w, topology_param(params, Topology::Strip));
}

}  // namespace arete::lod::geomipmap
