#pragma once

#include <glm/glm.hpp>

#include "arete/core/view.h"

namespace arete::app {

/// What the pilot asks for: -1, 0 or 1 along the camera's right, forward and the world's up.
struct FlyInput {
  int right = 0, forward = 0, up = 0;
  bool fast = false;
  glm::dvec2 dragged{0};  ///< pixels since the last frame, y down
};

/// Metres a second at this height above the ground: its height, 3 at least; five times with `fast`.
double fly_speed(double height_above_ground, bool fast);

/// The camera after `seconds` of flight. A drag over the viewport's height turns by fovy.
Pose flown(const View& view, const FlyInput& input, double seconds, double height_above_ground);

}  // namespace arete::app
