#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/glm.hpp>

#include "arete/core/screen_error.h"
#include "arete/core/view.h"
#include "arete/lod/bintree/record.h"

namespace arete::lod::bintree {

/// A vertex as the tests see it: where it stands and what its removal may change. World metres.
struct Ball {
  glm::dvec3 centre;
  double delta, radius;  ///< of its record
};

/// One frame's tests of a vertex. They depend on the vertex and the frame alone, bit by bit, so
/// both triangles that a vertex halves agree [METHODS 8.7]; with nested balls an active vertex has
/// active parents, so the surface conforms.
class Criterion {
 public:
  /// `sharper`: 1, or how many times less error than allowed is asked for.
  Criterion(const View& view, const ScreenError& error, double sharper = 1)
      : eye_(view.eye),
        nu_(std::min(sharper * kFar / std::max(error.allowed_m(kFar), 1e-300), kMostNu)),
        floor_(error.allowed_m(0)),
        planes_(frustum_planes(view)) {}

  /// |P - v| < nu delta + r [LindstromPascucci2002; METHODS 3.2]: where it fails, the error of
  /// everything below the vertex is within the tolerance. Deviation: a vertex whose delta is
  /// allowed at any distance (0, but for a budget's sake more) is never selected.
  bool selected(const Ball& ball) const { return selected(ball, squared(ball)); }
  bool selected(const Ball& ball, double squared) const {
    const double reach = this->reach(ball);
    return ball.delta > floor_ && squared < reach * reach;
  }
  /// |P - v|^2.
  double squared(const Ball& ball) const {
    const glm::dvec3 d = ball.centre - eye_;
    return glm::dot(d, d);
  }
  /// Radius of the tau-sphere about the vertex: nu delta + r [BaoPajarolaShafae2004, eq. 5].
  double reach(const Ball& ball) const { return nu_ * ball.delta + ball.radius; }

  /// False when the ball lies outside one of the frustum's planes. Those of bits `inside`, which
  /// balls around it lie inside, are not looked at again: that changes no answer. Adds the planes
  /// that this ball lies inside.
  bool visible(const Ball& ball, unsigned& inside) const {
    if (inside == kAllInside) return true;
    const double surely = ball.radius + slack(ball);
    for (unsigned i = 0; i < kPlanes; ++i) {
      if ((inside & (1U << i)) != 0) continue;
      const double height = this->height(ball.centre, i);
      if (height < -ball.radius) return false;
      if (height > surely) inside |= 1U << i;
    }
    return true;
  }
  /// Least height of the centre over the planes: visible() where it is not below -radius.
  double lowest(const Ball& ball) const {
    double least = height(ball.centre, 0);
    for (unsigned i = 1; i < kPlanes; ++i) least = std::min(least, height(ball.centre, i));
    return least;
  }
  /// More than the rounding of any test of the ball.
  static double slack(const Ball& ball) {
    return 1e-9 * (1 + std::abs(ball.centre.x) + std::abs(ball.centre.y) + ball.radius);
  }

  static constexpr unsigned kPlanes = 5;
  static constexpr unsigned kAllInside = (1U << kPlanes) - 1;

  glm::dvec3 eye() const { return eye_; }
  double nu() const { return nu_; }          ///< metres of distance a metre of error
  double floor_m() const { return floor_; }  ///< error allowed at any distance
  const std::array<glm::dvec4, kPlanes>& planes() const { return planes_; }

 private:
  static constexpr double kFar = 1e12;
  static constexpr double kMostNu = 1e30;  // of a tolerance of 0: nu * 0 must stay 0

  double height(glm::dvec3 p, unsigned i) const {
    const glm::dvec4& n = planes_[i];
    return n.x * p.x + n.y * p.y + n.z * p.z + n.w;
  }

  glm::dvec3 eye_;
  double nu_, floor_;
  std::array<glm::dvec4, kPlanes> planes_;
};

}  // namespace arete::lod::bintree
