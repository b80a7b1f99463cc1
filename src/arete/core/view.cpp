#include "arete/core/view.h"

#include <cmath>

namespace arete {
namespace {

struct Basis {
  glm::dvec3 right, up, forward;
};

Basis basis(double yaw, double pitch) {
  const double cp = std::cos(pitch);
  const double sp = std::sin(pitch);
  const double cy = std::cos(yaw);
  const double sy = std::sin(yaw);
  return {{cy, -sy, 0}, {-sy * sp, -cy * sp, cp}, {sy * cp, cy * cp, sp}};
}

// Infinite reversed-Z projection times the rotation; rows are clip x, y, z, w.
glm::dmat4 clip_from_rotated(const View& v) {
  const Basis b = basis(v.yaw, v.pitch);
  const double fy = 1.0 / std::tan(v.fovy / 2);
  const double fx = fy * v.viewport_height / v.viewport_width;
  glm::dmat4 m(0);
  for (int c = 0; c < 3; ++c) {
    m[c][0] = fx * b.right[c];
    m[c][1] = fy * b.up[c];
    m[c][3] = b.forward[c];
  }
  m[3][2] = v.near_m;
  return m;
}

}  // namespace

double View::focal_px() const {
  return viewport_height / (2 * std::tan(fovy / 2));
}

glm::dvec3 View::forward() const {
  return basis(yaw, pitch).forward;
}

View make_view(const Pose& pose, int viewport_width, int viewport_height) {
  View v;
  v.eye = pose.eye;
  v.yaw = pose.yaw;
  v.pitch = pose.pitch;
  v.fovy = pose.fovy;
  v.near_m = pose.near_m;
  v.viewport_width = viewport_width;
  v.viewport_height = viewport_height;
  glm::dmat4 world_to_camera(1);
  world_to_camera[3] = glm::dvec4(-v.eye, 1);
  v.clip_from_world = clip_from_rotated(v) * world_to_camera;
  return v;
}

glm::dmat4 clip_from_camera(const View& view) {
  glm::dmat4 to_eye(1);
  to_eye[3] = glm::dvec4(view.eye, 1);
  return view.clip_from_world * to_eye;
}

glm::dvec3 project(const View& view, glm::dvec3 world) {
  const glm::dvec4 c = view.clip_from_world * glm::dvec4(world, 1);
  return {(c.x / c.w * 0.5 + 0.5) * view.viewport_width,
          (c.y / c.w * 0.5 + 0.5) * view.viewport_height, c.w};
}

std::array<glm::dvec4, 5> frustum_planes(const View& view) {
  const glm::dmat4 t = glm::transpose(view.clip_from_world);  // rows as columns
  std::array<glm::dvec4, 5> planes{t[3] + t[0], t[3] - t[0], t[3] + t[1], t[3] - t[1], t[3] - t[2]};
  for (glm::dvec4& p : planes) p /= glm::length(glm::dvec3(p));
  return planes;
}

bool may_see(const std::array<glm::dvec4, 5>& planes, glm::dvec3 box_min, glm::dvec3 box_max) {
  for (const glm::dvec4& p : planes) {
    const glm::dvec3 far_corner{p.x > 0 ? box_max.x : box_min.x, p.y > 0 ? box_max.y : box_min.y,
                                p.z > 0 ? box_max.z : box_min.z};
    if (p.x * far_corner.x + p.y * far_corner.y + p.z * far_corner.z + p.w < 0) return false;
  }
  return true;
}

}  // namespace arete
