#include "arete/scene/path.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace arete::scene {
namespace {

using Values = std::array<double, 6>;
constexpr std::size_t kYaw = 3;
constexpr double kTurn = 2 * std::numbers::pi;

Values values_of(const Keyframe& k) {
  return {k.eye.x, k.eye.y, k.eye.z, k.yaw, k.pitch, k.fovy};
}

// The angle equal to `yaw` modulo a turn that is nearest to `before`.
double unwrap(double yaw, double before) {
  return yaw - kTurn * std::round((yaw - before) / kTurn);
}

// Slope at the middle of three samples: that of the parabola through them; 0 where it stands still,
// so that a hover hovers.
double slope(double before, double here, double after, double dt_before, double dt_after) {
  if (before == here || here == after) return 0;
  const double a = (here - before) / dt_before;
  const double b = (after - here) / dt_after;
  return (a * dt_after + b * dt_before) / (dt_before + dt_after);
}

double hermite(double a, double slope_a, double b, double slope_b, double dt, double u) {
  const double u2 = u * u;
  const double u3 = u2 * u;
  return a * (2 * u3 - 3 * u2 + 1) + b * (3 * u2 - 2 * u3) +
         dt * (slope_a * (u3 - 2 * u2 + u) + slope_b * (u3 - u2));
}

bool same_pose(const Keyframe& a, const Keyframe& b) {
  return a.eye == b.eye && std::abs(unwrap(a.yaw, b.yaw) - b.yaw) < 1e-9 && a.pitch == b.pitch &&
         a.fovy == b.fovy;
}

}  // namespace

Path::Path(std::vector<Keyframe> keyframes) : keyframes_(std::move(keyframes)) {
  assert(!keyframes_.empty());
  const std::size_t n = keyframes_.size();
  for (const Keyframe& k : keyframes_) {
    values_.push_back(values_of(k));
    if (values_.size() < 2) continue;
    values_.back()[kYaw] = unwrap(k.yaw, values_[values_.size() - 2][kYaw]);
  }
  closed_ = n > 2 && same_pose(keyframes_.front(), keyframes_.back());
  slopes_.assign(n, Values{});
  for (std::size_t i = 0; i < n; ++i) {
    const bool at_end = i == 0 || i + 1 == n;
    if (at_end && !closed_) continue;
    const std::size_t before = i == 0 ? n - 2 : i - 1;
    const std::size_t after = i + 1 == n ? 1 : i + 1;
    const double dt_before = keyframes_[before + 1].t - keyframes_[before].t;
    const double dt_after = keyframes_[after].t - keyframes_[after - 1].t;
    for (std::size_t c = 0; c < slopes_[i].size(); ++c) {
      const double here = values_[i][c];
      // Across the seam a yaw may differ by whole turns.
      const double b = c == kYaw ? unwrap(values_[before][c], here) : values_[before][c];
      const double a = c == kYaw ? unwrap(values_[after][c], here) : values_[after][c];
      slopes_[i][c] = slope(b, here, a, dt_before, dt_after);
    }
  }
}

double Path::duration() const {
  return keyframes_.back().t - keyframes_.front().t;
}

Pose Path::at(double t) const {
  const double time = std::clamp(t, 0.0, duration()) + keyframes_.front().t;
  const auto after = std::upper_bound(keyframes_.begin(), keyframes_.end(), time,
                                      [](double x, const Keyframe& k) { return x < k.t; });
  const auto last = static_cast<std::size_t>(keyframes_.size() - 1);
  const auto i =
      static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, after - keyframes_.begin() - 1));
  const std::size_t j = std::min(i + 1, last);
  const double dt = keyframes_[j].t - keyframes_[i].t;
  const double u = dt > 0 ? (time - keyframes_[i].t) / dt : 0;
  Values v{};
  for (std::size_t c = 0; c < v.size(); ++c) {
    v[c] = hermite(values_[i][c], slopes_[i][c], values_[j][c], slopes_[j][c], dt, u);
  }
  Pose pose;
  pose.eye = {v[0], v[1], v[2]};
  pose.yaw = std::remainder(v[kYaw], kTurn);
  pose.pitch = v[4];
  pose.fovy = v[5];
  return pose;
}

}  // namespace arete::scene
