#pragma once

#include <array>

#include <glm/glm.hpp>

namespace arete {

/// A pinhole camera without roll. World metres; square pixels; reversed-Z clip space with the far
/// plane at infinity (depth 1 at the near plane, 0 at infinity).
struct View {
  glm::dvec3 eye{0};
  double yaw = 0;                    ///< radians, 0 = north, clockwise (east = pi/2)
  double pitch = 0;                  ///< radians above the horizon; negative looks down
  double fovy = 1.0471975511965976;  ///< radians
  double near_m = 0.1;               ///< metres
  int viewport_width = 1280, viewport_height = 720;
  glm::dmat4 clip_from_world{1};

  /// Focal length in pixels: H / (2 tan(fovy/2)) [METHODS 1.3].
  double focal_px() const;
  glm::dvec3 forward() const;
};

/// What make_view is told; see View for units.
struct Pose {
  glm::dvec3 eye{0};
  double yaw = 0, pitch = 0, fovy = 1.0471975511965976, near_m = 0.1;
};

View make_view(const Pose& pose, int viewport_width, int viewport_height);

/// clip_from_world with the eye moved to the origin: for camera-relative drawing.
glm::dmat4 clip_from_camera(const View& view);

/// Window position in pixels (x right, y up from the lower left corner) of a world point and its
/// distance along the view axis in metres (w); the position means nothing when w <= 0.
glm::dvec3 project(const View& view, glm::dvec3 world);

/// Frustum planes (n, d), unit normals pointing inward: n.p + d >= 0 inside.
/// Order: left, right, bottom, top, near. The far plane is at infinity.
std::array<glm::dvec4, 5> frustum_planes(const View& view);

/// True when the box may touch the frustum (conservative: never false for a visible box).
bool may_see(const std::array<glm::dvec4, 5>& planes, glm::dvec3 box_min, glm::dvec3 box_max);

}  // namespace arete
