#include "map_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pick.h"

namespace arete::app {
namespace {

constexpr double kSteepest = 89 * std::numbers::pi / 180;
constexpr double kMargin = 0.95;  // of the half viewport that the home view fills

}  // namespace

Pose pose_of(const View& view) {
  return {view.eye, view.yaw, view.pitch, view.fovy, view.near_m};
}

Pose panned(const View& view, glm::dvec3 grabbed, glm::dvec2 cursor) {
  // Close to the horizon a pixel is worth kilometres: there the land must not race away.
  constexpr double kFarthest = 20;
  Pose pose = pose_of(view);
  const glm::dvec3 ray = cursor_ray(view, cursor);
  const double t = (grabbed.z - view.eye.z) / ray.z;
  if (std::isfinite(t) && t > 0 && t < kFarthest * glm::length(grabbed - view.eye)) {
    pose.eye = grabbed - t * ray;
  }
  return pose;
}

Pose zoomed(const View& view, glm::dvec3 pivot, double factor) {
  Pose pose = pose_of(view);
  pose.eye = pivot + factor * (view.eye - pivot);
  return pose;
}

Pose turned(const View& view, glm::dvec3 pivot, double yaw, double pitch) {
  Pose pose = pose_of(view);
  const CameraAxes before = camera_axes(view.yaw, view.pitch);
  pose.yaw += yaw;
  pose.pitch = std::clamp(view.pitch + pitch, -kSteepest, kSteepest);
  const CameraAxes after = camera_axes(pose.yaw, pose.pitch);
  const glm::dvec3 d = pivot - view.eye;
  pose.eye = pivot - (glm::dot(d, before.right) * after.right + glm::dot(d, before.up) * after.up +
                      glm::dot(d, before.forward) * after.forward);
  return pose;
}

Pose lifted(const Pose& pose, const LeveledGround& ground, double clearance) {
  Pose up = pose;
  up.eye.z = std::max(up.eye.z, height_below(ground, up.eye) + clearance);
  return up;
}

Pose home_pose(const scene::Ground& ground, double aspect) {
  const Affine2& a = ground.world_from_post;
  const glm::dvec2 last(ground.cols - 1, ground.rows - 1);
  const glm::dvec2 centre = a.apply(last.x / 2, last.y / 2);
  const glm::dvec3 target(centre, ground_height(ground, centre));
  Pose pose;
  pose.pitch = -40 * std::numbers::pi / 180;
  const CameraAxes axes = camera_axes(pose.yaw, pose.pitch);
  const double ty = kMargin * std::tan(pose.fovy / 2);
  double distance = 1;
  for (const glm::dvec2 post : {glm::dvec2(0), {last.x, 0}, {0, last.y}, last}) {
    for (const double z : {ground.z_min, ground.z_max}) {
      // The corner at d from the target is seen when |d.right| <= tx (distance + d.forward), and
      // likewise upward.
      const glm::dvec3 d = glm::dvec3(a.apply(post.x, post.y), z) - target;
      const double needed = std::max(std::abs(glm::dot(d, axes.right)) / (ty * aspect),
                                     std::abs(glm::dot(d, axes.up)) / ty);
      distance = std::max(distance, needed - glm::dot(d, axes.forward));
    }
  }
  pose.eye = target - distance * axes.forward;
  return pose;
}

}  // namespace arete::app
