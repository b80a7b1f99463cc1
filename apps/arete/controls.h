#pragma once

#include <optional>

#include "arete/core/view.h"
#include "arete/scene/path.h"

#include "fly_camera.h"
#include "quantities.h"

namespace arete::app {

/// Mouse and keys of one frame, whatever window they come from.
struct Input {
  glm::dvec2 cursor{0};                              ///< pixels, y down
  glm::dvec2 moved{0};                               ///< pixels since the last frame
  bool left = false, middle = false, right = false;  ///< held
  bool double_click = false;
  double wheel = 0;  ///< notches, away from the user is positive
  FlyInput fly;      ///< keys only
  double seconds = 0;
};

enum class ControlMode { Map, Fly };

/// Turns input into a camera: map-style (the grabbed ground follows the cursor) or flying.
class Controls {
 public:
  /// `ground` must outlive the controls.
  Controls(const scene::Ground& ground, const Pose& start);

  void update(const Input& input, FrameSize size);
  /// Goes there smoothly in about a second.
  void glide_to(const Pose& pose);
  void set_pose(const Pose& pose);
  void toggle_fly();

  const Pose& pose() const { return pose_; }
  ControlMode mode() const { return mode_; }

 private:
  void update_map(const Input& input, const View& view);
  void update_fly(const Input& input, const View& view);
  void glide(double seconds);
  void grab(const Input& input, const View& view);
  double clearance() const;

  const scene::Ground& ground_;
  Pose pose_;
  ControlMode mode_ = ControlMode::Map;
  std::optional<glm::dvec3> grabbed_;  ///< held while a mouse button is down
  std::optional<scene::Path> glide_;
  double glided_ = 0;  ///< seconds
};

}  // namespace arete::app
