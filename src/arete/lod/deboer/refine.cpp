#include <cmath>

#include "arete/lod/deboer/deboer.h"
#include "arete/lod/params.h"
#include "arete/lod/uniform_engine.h"

namespace arete::lod::deboer {
namespace {

// C = A / T with A = n / |t|, near distance over near-plane top, and T = 2 tau / v_res
// [deBoer2000]; |t| = n tan(fovy / 2), so C = f / tau.
double metres_per_metre(const View& view, double tolerance_px) {
  const double a = 1 / std::tan(view.fovy / 2);
  const double t = 2 * tolerance_px / view.viewport_height;
  return a / t;
}

enum class Morph { None, Trilinear };

class DeboerEngine final : public UniformEngine {
 public:
  // Deviation: "edge vertices towards coarser neighbours are not morphed", and neither are the
  // coarser neighbour's towards the finer one, or they would part; between equals both follow one.
  DeboerEngine(const store::Terrain& terrain, int log2_cells, Topology topology, Morph morph)
      : UniformEngine(terrain, log2_cells,
                      std::make_unique<UniformMesh>(topology, UniformMesh::Towards::Stored),
                      UniformField::Sides::StillButBetweenEquals),
        morph_(morph) {}

 protected:
  // The highest level with L > D_n, D_n = delta_n C, L from the eye to the block's centre, and
  // t = (L - D_n) / (D_n+1 - D_n). The distance to the centre bounds no post's.
  std::uint64_t set_levels(const View& view, const ScreenError&, double tolerance_px) override {
    const PatchTable& blocks = drawer_.table();
    field().look_from(view.eye);
    const double c = metres_per_metre(view, tolerance_px);
    for (int p = 0; p < blocks.size(); ++p) {
      if (!blocks.drawable(p)) continue;
      const glm::dvec3 centre = (blocks.box_min(p) + blocks.box_max(p)) / 2.0;
      const double distance = glm::length(view.eye - centre);
      const float level = coarsest_level(blocks.log2_cells(), distance,
                                         [&](int l) { return table().bound(p, l) * c; });
      field().set_level(p, morph_ == Morph::Trilinear ? level : std::floor(level));
    }
    return static_cast<std::uint64_t>(blocks.size());
  }

 private:
  Morph morph_;
};

}  // namespace

std::unique_ptr<Engine> open(const store::Terrain& terrain, const Params& params) {
  check_names(params, {"patch", "topology", "trilinear"});
  const int w = parse_uniform_patch(param(params, "patch", "auto"), terrain.manifest());
  return std::make_unique<DeboerEngine>(
      terrain, w, topology_param(params, Topology::Strip),
      flag_param(params, "trilinear") ? Morph::Trilinear : Morph::None);
}

}  // namespace arete::lod::deboer
