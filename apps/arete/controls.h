#pragma once

#include <optional>

#include "arete/core/view.h"
#include "arete/scene/path.h"

#include "fly_camera.h"
#include "ground.h"
#include "quantities.h"

namespace arete::app {

/// Mouse and keys of one frame, whatever window they come from.
struct Input {
  glm::dvec2 cursor{0};                              ///< pixels, y down
  glm::dvec2 moved{0};                               ///< pixels since the last frame
  bool left = false, middle = false, right = false;  ///< held
  std::optional<glm::dvec2> pressed_at{};  ///< where a button went down since the last frame
  bool double_click = false;
  double wheel = 0;  ///< notches, away from the user is positive
  FlyInput fly;      ///< keys only
  double seconds = 0;
};

enum class ControlMode { Map, Fly };

/// Turns input into a camera: map-style (the grabbed ground follows the cursor) or flying.
class Controls {
 public:
  /// `ground` must outlive the controls, or stand_on() be called before it goes.
  Controls(const LeveledGround& ground, const Pose& start);

  /// Other ground under the same camera.
  void stand_on(const LeveledGround& ground) { ground_ = &ground; }
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
  /// The mouse's way in this frame, pixels: from where a button went down, if it just did.
  glm::dvec2 grab(const Input& input, const View& view);
  double clearance() const;

  const LeveledGround* ground_;
  Pose pose_;
  ControlMode mode_ = ControlMode::Map;
  std::optional<glm::dvec3> grabbed_;  ///< held while a mouse button is down
  std::optional<scene::Path> glide_;
  double glided_ = 0;  ///< seconds
};

}  // namespace arete::app
