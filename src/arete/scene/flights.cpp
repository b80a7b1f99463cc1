#include "arete/scene/flights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::scene {
namespace {

constexpr double kPi = std::numbers::pi;

glm::dvec2 centre_of(const Ground& g) {
  return g.world_from_post.apply((g.cols - 1) * 0.5, (g.rows - 1) * 0.5);
}

double yaw_towards(glm::dvec2 direction) {
  return std::atan2(direction.x, direction.y);
}

// A full circle around the centre, looking at it.
Path circle(const Ground& ground) {
  constexpr int kSteps = 120;
  const Scale scale = scale_of(ground);
  const glm::dvec2 centre = centre_of(ground);
  const double middle = ground_at(ground, centre);
  const glm::dvec2 corner = ground.world_from_post.apply(0, 0);
  const double radius = std::max(1.1 * glm::distance(corner, centre), 4 * scale.spacing);
  const double height = std::max(ground.z_max + 2 * scale.spacing, middle + 0.45 * radius);
  std::vector<Keyframe> keyframes;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = kPi + 2 * kPi * (i % kSteps) / kSteps;  // starts in the south
    const glm::dvec2 arm{radius * std::sin(angle), radius * std::cos(angle)};
    Keyframe k;
    k.t = 60.0 * i / kSteps;
    k.eye = {centre + arm, height};
    k.yaw = yaw_towards(-arm);
    k.pitch = -std::atan2(height - middle, radius);
    keyframes.push_back(k);
  }
  return raise_above_ground(std::move(keyframes), ground, scale.spacing);
}

// From above the whole land down to a few posts over its centre; height falls by equal ratios.
Path descend(const Ground& ground) {
  constexpr int kSteps = 120;
  const Scale scale = scale_of(ground);
  const glm::dvec2 centre = centre_of(ground);
  const double high = std::max(1.2 * scale.extent, 20 * scale.spacing);
  const double low = 5 * scale.spacing;
  std::vector<Keyframe> keyframes;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = static_cast<double>(i) / kSteps;
    const double eased = t * t * (3 - 2 * t);
    const double above = high * std::pow(low / high, eased);
    const glm::dvec2 plan = centre - glm::dvec2(0, 0.3 * scale.extent * (1 - eased));
    Keyframe k;
    k.t = 30 * t;
    k.eye = {plan, ground_at(ground, plan) * eased + ground.z_max * (1 - eased) + above};
    k.pitch = -(75 - 67 * eased) * kPi / 180;
    keyframes.push_back(k);
  }
  return raise_above_ground(std::move(keyframes), ground, scale.spacing);
}

// Raises both ends of a stretch that dips below; false when nothing was raised.
bool raise_once(std::vector<Keyframe>& keyframes, const Ground& ground, double margin_m) {
  constexpr int kSamples = 24;
  const Path path(keyframes);
  const double start = keyframes.front().t;
  std::vector<double> lift(keyframes.size(), 0.0);
  for (std::size_t i = 0; i + 1 < keyframes.size(); ++i) {
    const double dt = keyframes[i + 1].t - keyframes[i].t;
    for (int s = 0; s <= kSamples; ++s) {
      const glm::dvec3 eye = path.at(keyframes[i].t - start + dt * s / kSamples).eye;
      const double missing = ground_at(ground, {eye.x, eye.y}) + margin_m - eye.z;
      lift[i] = std::max(lift[i], missing);
      lift[i + 1] = std::max(lift[i + 1], missing);
    }
  }
  if (path.closed()) lift.front() = lift.back() = std::max(lift.front(), lift.back());
  for (std::size_t i = 1; i < lift.size(); ++i) {  // a hover is raised as one
    if (keyframes[i].eye == keyframes[i - 1].eye) lift[i] = std::max(lift[i], lift[i - 1]);
  }
  for (std::size_t i = lift.size() - 1; i-- > 0;) {
    if (keyframes[i].eye == keyframes[i + 1].eye) lift[i] = std::max(lift[i], lift[i + 1]);
  }
  for (std::size_t i = 0; i < lift.size(); ++i) keyframes[i].eye.z += lift[i] * 1.01;
  return *std::max_element(lift.begin(), lift.end()) > 0;
}

}  // namespace

Scale scale_of(const Ground& ground) {
  const Affine2& a = ground.world_from_post;
  const double spacing = std::sqrt(std::abs(a.determinant()));
  const double width = std::hypot(a.m[0], a.m[3]) * (ground.cols - 1);
  const double height = std::hypot(a.m[1], a.m[4]) * (ground.rows - 1);
  return {spacing, std::max({width, height, spacing})};
}

double ground_at(const Ground& ground, glm::dvec2 world) {
  const glm::dvec2 post = ground.world_from_post.inverse(world);
  return ground.height(post.x, post.y);
}

Path raise_above_ground(std::vector<Keyframe> keyframes, const Ground& ground, double margin_m) {
  constexpr int kPasses = 40;
  for (int pass = 0; pass < kPasses && raise_once(keyframes, ground, margin_m); ++pass) {
  }
  return Path(std::move(keyframes));
}

Path make_path(const std::string& name_or_file, const Ground& ground) {
  if (name_or_file == "flyover") return fly_over(ground);
  if (name_or_file == "orbit") return circle(ground);
  if (name_or_file == "descent") return descend(ground);
  const std::filesystem::path file(name_or_file);
  std::error_code ignored;
  if (file.extension() != ".json" && !std::filesystem::exists(file, ignored)) {
    throw Error(
        ErrorCode::Usage,
        fmt::format("{}: no such path: use flyover, orbit, descent or a JSON file", name_or_file));
  }
  return read_path(file);
}

}  // namespace arete::scene
