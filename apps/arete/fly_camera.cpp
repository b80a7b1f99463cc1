#include "fly_camera.h"

#include <algorithm>
#include <numbers>

#include "map_camera.h"
#include "pick.h"

namespace arete::app {

double fly_speed(double height_above_ground, bool fast) {
  constexpr double kSlowest = 3;
  constexpr double kFast = 5;
  return std::max(height_above_ground, kSlowest) * (fast ? kFast : 1);
}

Pose flown(const View& view, const FlyInput& input, double seconds, double height_above_ground) {
  constexpr double kSteepest = 89 * std::numbers::pi / 180;
  Pose pose = pose_of(view);
  const double radians_per_pixel = view.fovy / view.viewport_height;
  pose.yaw += input.dragged.x * radians_per_pixel;
  pose.pitch = std::clamp(pose.pitch - input.dragged.y * radians_per_pixel, -kSteepest, kSteepest);
  const CameraAxes axes = camera_axes(pose.yaw, pose.pitch);
  const glm::dvec3 wish = axes.right * static_cast<double>(input.right) +
                          axes.forward * static_cast<double>(input.forward) +
                          glm::dvec3(0, 0, input.up);
  if (const double length = glm::length(wish); length > 0) {
    pose.eye += wish / length * seconds * fly_speed(height_above_ground, input.fast);
  }
  return pose;
}

}  // namespace arete::app
