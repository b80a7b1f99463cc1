#include "arete/lod/culling.h"

#include <algorithm>
#include <cmath>

namespace arete::lod {
namespace {

// Grows a rectangle of posts by points.
class Bounds {
 public:
  explicit Bounds(const Affine2& world_from_post) : affine_(world_from_post) {}
  void add(glm::dvec3 p) {
    const glm::dvec2 post = affine_.inverse(glm::dvec2(p));
    lo_ = glm::min(lo_, post);
    hi_ = glm::max(hi_, post);
  }
  PostRect rect() const {
    const auto whole = [](double v) { return static_cast<std::int32_t>(std::clamp(v, -1e9, 1e9)); };
    if (lo_.x > hi_.x) return {};
    return {whole(std::floor(lo_.x)), whole(std::floor(lo_.y)), whole(std::ceil(hi_.x)) + 1,
            whole(std::ceil(hi_.y)) + 1};
  }

 private:
  const Affine2& affine_;
  glm::dvec2 lo_{1e300}, hi_{-1e300};
};

// The part of a segment between two heights, if any, adds its ends.
void add_clipped(Bounds& bounds, glm::dvec3 a, glm::dvec3 b, double z_min, double z_max) {
  double t0 = 0;
  double t1 = 1;
  const double dz = b.z - a.z;
  if (dz == 0) {
    if (a.z < z_min || a.z > z_max) return;
  } else {
    const double u = (z_min - a.z) / dz;
    const double v = (z_max - a.z) / dz;
    t0 = std::max(t0, std::min(u, v));
    t1 = std::min(t1, std::max(u, v));
    if (t0 > t1) return;
  }
  bounds.add(a + t0 * (b - a));
  bounds.add(a + t1 * (b - a));
}

}  // namespace

// The frustum, cut off behind the terrain, meets the slab between lowest and highest ground in a
// polyhedron whose corners all lie on the frustum's edges (the eye's four and the far four).
Culling::Culling(const View& view, const Affine2& world_from_post, glm::dvec3 box_min,
                 glm::dvec3 box_max)
    : planes_(frustum_planes(view)) {
  const glm::dmat4 world_from_clip = glm::inverse(clip_from_camera(view));
  const double reach =
      glm::length(glm::max(glm::abs(view.eye - box_min), glm::abs(view.eye - box_max))) + 1;
  std::array<glm::dvec3, 4> far_corner;
  for (std::size_t k = 0; k < 4; ++k) {
    const double x = k == 0 || k == 3 ? -1 : 1;
    const double y = k < 2 ? -1 : 1;
    const glm::dvec4 p = world_from_clip * glm::dvec4(x * reach, y * reach, view.near_m, reach);
    far_corner[k] = view.eye + glm::dvec3(p);
  }
  Bounds bounds(world_from_post);
  for (std::size_t k = 0; k < 4; ++k) {
    add_clipped(bounds, view.eye, far_corner[k], box_min.z, box_max.z);
    add_clipped(bounds, far_corner[k], far_corner[(k + 1) % 4], box_min.z, box_max.z);
  }
  rect_ = bounds.rect();
}

}  // namespace arete::lod
