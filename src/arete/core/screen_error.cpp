#include "arete/core/screen_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arete {

double pixel_scale(const View& v, ErrorScale scale) {
  const double ty = std::tan(v.fovy / 2);
  const double tx = ty * v.viewport_width / v.viewport_height;
  const double f = v.focal_px();
  if (scale == ErrorScale::Angular) return v.viewport_width / (2 * std::atan(tx));
  const double rho2 = tx * tx + ty * ty;
  const double rigorous = f * (1 + rho2);  // alpha_rig = f (1 + rho^2) [METHODS 1.3]
  if (scale == ErrorScale::Rigorous) return rigorous;
  // alpha_up = f sqrt(1+tx^2+ty^2) sqrt((|cos t| + ty |sin t|)^2 + (tx |sin t|)^2) [METHODS 1.3]
  const double c = std::abs(std::cos(v.pitch));
  const double s = std::abs(std::sin(v.pitch));
  return std::min(rigorous, f * std::sqrt(1 + rho2) * std::hypot(c + ty * s, tx * s));
}

namespace {

// s of ScreenError: Z = D / sqrt(1 + rho^2) and the displaced Z' >= Z - |sin pitch| delta, so
// f sqrt(1 + rho^2) N delta / (sqrt(1 + rho^2) Z') <= alpha delta / (D - s delta).
double approach(const View& v, ErrorScale scale) {
  if (scale == ErrorScale::Angular) return 0;
  const double ty = std::tan(v.fovy / 2);
  const double tx = ty * v.viewport_width / v.viewport_height;
  const double widest = std::sqrt(1 + tx * tx + ty * ty);
  return scale == ErrorScale::Upright ? widest * std::abs(std::sin(v.pitch)) : widest;
}

}  // namespace

ScreenError::ScreenError(const View& view, double tolerance_px, ErrorScale scale)
    : alpha_(pixel_scale(view, scale)),
      approach_(approach(view, scale)),
      slope_(tolerance_px / (alpha_ + approach_ * tolerance_px)),
      near_m_(view.near_m) {}

ScreenError ScreenError::coarser(double times) const {
  ScreenError out = *this;
  out.slope_ *= times;
  if (times > kNearTimes) out.nearest_m_ = near_m_ * (std::pow(times / kNearTimes, kNearPower) - 1);
  return out;
}

double ScreenError::pixels(double delta_m, double distance_m) const {
  if (delta_m <= 0) return 0;
  const double nearest = distance_m - approach_ * delta_m;
  return nearest > 0 ? alpha_ * delta_m / nearest : std::numeric_limits<double>::infinity();
}

}  // namespace arete
