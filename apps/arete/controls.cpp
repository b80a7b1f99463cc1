#include "controls.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "map_camera.h"
#include "pick.h"

namespace arete::app {
namespace {

scene::Keyframe keyframe(double t, const Pose& pose) {
  return {t, pose.eye, pose.yaw, pose.pitch, pose.fovy};
}

}  // namespace

Controls::Controls(const LeveledGround& ground, const Pose& start)
    : ground_(&ground), pose_(start) {}

double Controls::clearance() const {
  return 0.5 * post_spacing(*ground_);
}

void Controls::set_pose(const Pose& pose) {
  glide_.reset();
  grabbed_.reset();
  pose_ = pose;
}

void Controls::glide_to(const Pose& pose) {
  Pose target = pose;
  // The short way round.
  target.yaw = pose_.yaw + std::remainder(pose.yaw - pose_.yaw, 2 * std::numbers::pi);
  glide_.emplace(std::vector{keyframe(0, pose_), keyframe(1, target)});
  glided_ = 0;
}

void Controls::toggle_fly() {
  mode_ = mode_ == ControlMode::Map ? ControlMode::Fly : ControlMode::Map;
  grabbed_.reset();
}

void Controls::update(const Input& input, FrameSize size) {
  const bool touched = input.left || input.middle || input.right || input.wheel != 0;
  if (glide_ && (!touched || input.double_click)) {
    glide(input.seconds);
    return;
  }
  glide_.reset();
  const View view = make_view(pose_, size.width, size.height);
  if (input.double_click) {
    if (const auto target = ground_along(*ground_, view.eye, cursor_ray(view, input.cursor))) {
      glide_to(lifted(zoomed(view, *target, 0.3), *ground_, clearance()));
    }
  } else if (mode_ == ControlMode::Map) {
    update_map(input, view);
  } else {
    update_fly(input, view);
  }
}

void Controls::glide(double seconds) {
  glided_ += seconds;
  pose_ = lifted(glide_->at(std::min(glided_, 1.0)), *ground_, clearance());
  if (glided_ >= 1) {
    glide_.reset();
  }
}

glm::dvec2 Controls::grab(const Input& input, const View& view) {
  const bool held = input.left || input.middle || input.right;
  if (!held) {
    grabbed_.reset();
  } else if (input.pressed_at || !grabbed_) {
    const glm::dvec2 from = input.pressed_at.value_or(input.cursor - input.moved);
    grabbed_ = ground_along(*ground_, view.eye, cursor_ray(view, from));
    return input.cursor - from;
  }
  return input.moved;
}

void Controls::update_map(const Input& input, const View& view) {
  constexpr double kNotch = 0.85;      // distance left after one notch of the wheel
  constexpr double kRadians = 0.005;   // per dragged pixel
  constexpr double kZoomPixels = 200;  // dragged pixels that double the distance
  const glm::dvec2 moved = grab(input, view);
  if (input.wheel != 0) {
    if (const auto pivot = ground_along(*ground_, view.eye, cursor_ray(view, input.cursor))) {
      pose_ = zoomed(view, *pivot, std::pow(kNotch, input.wheel));
    }
  } else if (grabbed_ && input.left) {
    pose_ = panned(view, *grabbed_, input.cursor);
  } else if (grabbed_ && input.middle) {
    pose_ = turned(view, *grabbed_, moved.x * kRadians, -moved.y * kRadians);
  } else if (grabbed_ && input.right) {
    pose_ = zoomed(view, *grabbed_, std::exp2(moved.y / kZoomPixels));
  }
  pose_ = lifted(pose_, *ground_, clearance());
}

void Controls::update_fly(const Input& input, const View& view) {
  FlyInput fly = input.fly;
  const bool held = input.left || input.right || input.middle;
  fly.dragged =
      held ? input.cursor - input.pressed_at.value_or(input.cursor - input.moved) : glm::dvec2(0);
  const double height = view.eye.z - height_below(*ground_, view.eye);
  pose_ = lifted(flown(view, fly, input.seconds, height), *ground_, clearance());
}

}  // namespace arete::app
