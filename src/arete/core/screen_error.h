#pragma once

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
/// A displacement of delta at distance D moves its image by at most alpha delta / (D - delta) px;
/// under Angular by alpha delta / D (an angle).
class ScreenError {
 public:
  ScreenError(const View& view, double tolerance_px, ErrorScale scale = ErrorScale::Upright);

  double alpha() const { return alpha_; }
  /// The largest vertical error in metres that stays within the tolerance at distance D:
  /// tau D / (alpha + tau), solved from alpha delta / (D - delta) = tau; tau D / alpha if angular.
  double allowed_m(double distance_m) const { return slope_ * distance_m; }
  /// allowed_m(1): metres per metre of distance.
  double slope() const { return slope_; }
  /// The bound in pixels for an error of delta_m at distance D; infinite when delta_m >= D.
  double pixels(double delta_m, double distance_m) const;

 private:
  ErrorScale scale_;
  double alpha_;
  double slope_;
};

/// alpha in pixels per radian for the view; see ErrorScale.
double pixel_scale(const View& view, ErrorScale scale);

}  // namespace arete
