#pragma once

#include <algorithm>

#include "arete/core/view.h"

namespace arete {

/// Which pixel scale turns a vertical error into pixels (METHODS 1.3).
enum class ErrorScale {
  Angular,   ///< alpha_ang = W/phi_x: error as an angle (SOAR's and SMART's notion; not a bound in
             ///< px)
  Upright,   ///< alpha_up: rigorous in px for vertical displacements and a camera without roll
  Rigorous,  ///< alpha_rig: rigorous in px for any displacement
};

/// The only code that turns metres into pixels.
/// A displacement of delta at distance D moves its image by at most alpha delta / (D - s delta) px,
/// where s delta bounds how much nearer it may bring the point along the view axis, in units of D /
/// Z: s = sqrt(1 + tx^2 + ty^2) |sin pitch| for vertical displacements, without the sine for any.
/// Under Angular s = 0 (an angle). The drawn point may lie outside the viewport. METHODS 1.3 has D
/// - delta, which is no bound when looking down with s > 1.
class ScreenError {
 public:
  static constexpr double kNearTimes = 8, kNearPower = 3;

  ScreenError(const View& view, double tolerance_px, ErrorScale scale = ErrorScale::Upright);

  double alpha() const { return alpha_; }
  /// The largest vertical error in metres that stays within the tolerance at distance D:
  /// tau D / (alpha + s tau), solved from alpha delta / (D - s delta) = tau.
  double allowed_m(double distance_m) const { return slope_ * std::max(distance_m, nearest_m_); }
  /// The tolerance that allowed_m keeps at distance D and beyond; infinite when there is none.
  double tolerance_px(double distance_m) const {
    // Far enough, distance cancels; and at 0 it must.
    return distance_m >= nearest_m_ ? pixels(slope_, 1) : pixels(allowed_m(distance_m), distance_m);
  }
  /// Allows `times` as much at every distance. Beyond kNearTimes also as if nothing
  /// were nearer than a distance that grows from 0 without bound: so enough `times` allow any error
  /// anywhere, even where the eye is inside a box. Moves allowed_m by at most
  /// |d allowed| / allowed <= (1 + kNearPower) |d times| / times for distances that count.
  ScreenError coarser(double times) const;
  /// The bound in pixels for an error of delta_m at distance D; infinite when s delta_m >= D.
  double pixels(double delta_m, double distance_m) const;

 private:
  double alpha_;
  double approach_;  ///< s
  double slope_;
  double near_m_;         ///< the view's near plane
  double nearest_m_ = 0;  ///< nearer is taken as this near
};

/// alpha in pixels per radian for the view; see ErrorScale.
double pixel_scale(const View& view, ErrorScale scale);

}  // namespace arete
