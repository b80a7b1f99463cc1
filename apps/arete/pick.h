#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "arete/core/view.h"

#include "ground.h"

namespace arete::app {

/// The camera's axes in the world; unit, right-handed with forward = up x right.
struct CameraAxes {
  glm::dvec3 right, up, forward;
};
CameraAxes camera_axes(double yaw, double pitch);

/// Unit direction from the eye through a cursor position: pixels, x right, y down from the upper
/// left corner.
glm::dvec3 cursor_ray(const View& view, glm::dvec2 cursor);

/// The first point of the ground that the ray from the eye meets, by heights in memory whose posts
/// stand about a 500th of their distance apart, and to about a thousandth of its distance; nothing
/// when the ray passes above it. Reads and asks for no tile. `direction` is unit.
std::optional<glm::dvec3> ground_along(const LeveledGround& ground, glm::dvec3 eye,
                                       glm::dvec3 direction);

}  // namespace arete::app
