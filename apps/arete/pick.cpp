#include "pick.h"

#include <algorithm>
#include <cmath>

namespace arete::app {
namespace {

/// Half the diagonal of the grid, metres.
double extent(const scene::Ground& ground) {
  const Affine2& a = ground.world_from_post;
  return glm::length(a.apply(ground.cols - 1, ground.rows - 1) - a.apply(0, 0));
}

/// Metres of the ray worth searching: it begins below the highest post and ends below the lowest
/// one or far outside.
struct Reach {
  double begin, end;
};

Reach reach(const scene::Ground& ground, glm::dvec3 eye, glm::dvec3 direction) {
  const double far = glm::length(glm::dvec2(eye)) + 4 * extent(ground);
  const double top = (ground.z_max - eye.z) / direction.z;
  const double bottom = (ground.z_min - 1 - eye.z) / direction.z;
  if (direction.z < 0) {
    return {std::max(top, 0.0), std::min(bottom, far)};
  }
  return {0, direction.z > 0 ? std::min(top, far) : far};
}

}  // namespace

CameraAxes camera_axes(double yaw, double pitch) {
  const glm::dvec3 right{std::cos(yaw), -std::sin(yaw), 0};
  const glm::dvec3 forward{std::sin(yaw) * std::cos(pitch), std::cos(yaw) * std::cos(pitch),
                           std::sin(pitch)};
  return {right, glm::cross(right, forward), forward};
}

glm::dvec3 cursor_ray(const View& view, glm::dvec2 cursor) {
  const CameraAxes axes = camera_axes(view.yaw, view.pitch);
  const double x = cursor.x - view.viewport_width / 2.0;
  const double y = view.viewport_height / 2.0 - cursor.y;
  return glm::normalize(axes.forward * view.focal_px() + axes.right * x + axes.up * y);
}

std::optional<glm::dvec3> ground_along(const LeveledGround& ground, glm::dvec3 eye,
                                       glm::dvec3 direction) {
  const auto [begin, end] = reach(ground, eye, direction);
  const auto above = [&](double t) {
    const glm::dvec3 p = eye + t * direction;
    const glm::dvec2 post = ground.world_from_post.inverse(glm::dvec2(p));
    return p.z > ground.height_of_level(post.x, post.y, level_for_distance(ground, t),
                                        store::Fetch::Held);
  };
  // Steps of half a post near the eye, of a 250th of the distance further away: about 2,000 at
  // most.
  double before = begin;
  for (double t = begin; t < end;) {
    before = t;
    t += std::max(post_spacing(ground) / 2, 0.004 * t);
    if (above(t)) {
      continue;
    }
    for (int i = 0; i < 40; ++i) {
      const double middle = (before + t) / 2;
      (above(middle) ? before : t) = middle;
    }
    return eye + t * direction;
  }
  return std::nullopt;
}

}  // namespace arete::app
