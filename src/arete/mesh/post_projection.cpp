#include "arete/mesh/post_projection.h"

namespace arete::mesh {

PostProjection::PostProjection(const View& view, const Affine2& world_from_post)
    : near_m(view.near_m) {
  // Relative to the eye first: the sum of large world coordinates would lose digits.
  const glm::dmat4 clip_from_eye = clip_from_camera(view);
  const auto project = [&](glm::dvec4 v) {
    const glm::dvec4 c = clip_from_eye * v;
    return glm::dvec3(c.x, c.y, c.w);
  };
  const auto& m = world_from_post.m;
  origin = project({m[2] - view.eye.x, m[5] - view.eye.y, -view.eye.z, 1});
  per_col = project({m[0], m[3], 0, 0});
  per_row = project({m[1], m[4], 0, 0});
  per_metre = project({0, 0, 1, 0});
}

}  // namespace arete::mesh
