#include "map_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pick.h"

namespace arete::app {
namespace {

constexpr double kSteepest = 89 * std::numbers::pi / 180;

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

Pose lifted(const Pose& pose, const scene::Ground& ground, double clearance) {
  Pose up = pose;
  up.eye.z = std::max(up.eye.z, ground_height(ground, glm::dvec2(up.eye)) + clearance);
  return up;
}

Pose home_pose(const scene::Ground& ground) {
  const Affine2& a = ground.world_from_post;
  const glm::dvec2 centre = a.apply((ground.cols - 1) / 2.0, (ground.rows - 1) / 2.0);
  const double half = glm::length(a.apply(ground.cols - 1, ground.rows - 1) - a.apply(0, 0)) / 2;
  Pose pose;
  pose.pitch = -40 * std::numbers::pi / 180;
  const double distance = std::max(half / std::tan(pose.fovy / 2), 1.0);
  pose.eye = glm::dvec3(centre, ground_height(ground, centre)) -
             distance * camera_axes(pose.yaw, pose.pitch).forward;
  return pose;
}

}  // namespace arete::app
