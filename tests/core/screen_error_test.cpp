#include "arete/core/screen_error.h"

#include <random>

#include <gtest/gtest.h>

namespace arete {
namespace {

// The bound of METHODS 1.3 against true projections: random poses, points in view, vertical moves.
double worst_share(ErrorScale scale) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const View v =
        make_view({.yaw = unit(random) * 6, .pitch = (unit(random) - 0.5) * 3.1}, 800, 600);
    const double tau = 0.1 + 8 * unit(random);
    const double depth = 10 + 1000 * unit(random);
    const glm::dvec4 ndc{(2 * unit(random) - 1) * depth, (2 * unit(random) - 1) * depth, v.near_m,
                         depth};
    const glm::dvec3 p = glm::inverse(v.clip_from_world) * ndc;
    const double allowed = ScreenError(v, tau, scale).allowed_m(glm::length(p));
    const glm::dvec3 a = project(v, p);
    const glm::dvec3 b = project(v, p + glm::dvec3(0, 0, unit(random) < 0.5 ? allowed : -allowed));
    if (b.z <= 0) continue;
    worst = std::max(worst, std::hypot(a.x - b.x, a.y - b.y) / tau);
  }
  return worst;
}

TEST(ScreenError, UprightIsABoundAndNearlyTight) {
  const double worst = worst_share(ErrorScale::Upright);
  EXPECT_LE(worst, 1 + 1e-9);
  EXPECT_GT(worst, 0.9);
}

TEST(ScreenError, RigorousIsABound) {
  EXPECT_LE(worst_share(ErrorScale::Rigorous), 1 + 1e-9);
}

// The control: the same test catches the angular scale, which is no bound in pixels.
TEST(ScreenError, AngularIsCaughtAsNoBound) {
  EXPECT_GT(worst_share(ErrorScale::Angular), 1.2);
}

// The worst place there is: an image corner while looking straight down.
double share_at_corners(double tau, double slope_factor) {
  double worst = 0;
  for (const double pitch : {-1.5707963, -1.2, -0.8, 0.0}) {
    const View v = make_view({.pitch = pitch}, 1280, 720);
    for (const double x : {-1.0, 1.0}) {
      for (const double y : {-1.0, 1.0}) {
        const double depth = 100;
        const glm::dvec3 p =
            glm::inverse(v.clip_from_world) * glm::dvec4(x * depth, y * depth, v.near_m, depth);
        for (const double sign : {-1.0, 1.0}) {
          const double delta = sign * slope_factor * ScreenError(v, tau).allowed_m(glm::length(p));
          const glm::dvec3 a = project(v, p);
          const glm::dvec3 b = project(v, p + glm::dvec3(0, 0, delta));
          worst = std::max(worst, std::hypot(a.x - b.x, a.y - b.y) / tau);
        }
      }
    }
  }
  return worst;
}

TEST(ScreenError, UprightHoldsInTheCornersLookingDown) {
  for (const double tau : {1.0, 2.0, 8.0, 60.0}) {
    EXPECT_LE(share_at_corners(tau, 1), 1 + 1e-9);
    EXPECT_GT(share_at_corners(tau, 1.001), 1);  // the control: it is attained there
  }
}

TEST(ScreenError, PixelsInvertsAllowed) {
  const View v = make_view({}, 800, 600);
  const ScreenError e(v, 2);
  EXPECT_NEAR(e.pixels(e.allowed_m(500), 500), 2, 1e-9);
}

TEST(ScreenError, CoarserSaysWhatItKeeps) {
  for (const double pitch : {0.0, -0.7, -1.5}) {
    const ScreenError asked(make_view({.pitch = pitch}, 800, 600), 2);
    for (const double times : {1.0, 1.5, 7.9}) {
      const ScreenError e = asked.coarser(times);
      for (const double distance : {0.0, 3.0, 500.0, 1e9}) {
        EXPECT_NEAR(e.allowed_m(distance), times * asked.allowed_m(distance), 1e-9 * distance);
        EXPECT_NEAR(e.tolerance_px(distance), e.tolerance_px(500), 1e-9);
      }
      EXPECT_NEAR(e.pixels(e.allowed_m(500), 500), e.tolerance_px(500), 1e-9);
      EXPECT_GE(e.tolerance_px(500), 2 * times * (1 - 1e-9));
    }
    // Beyond, what is near is given up: any error is allowed anywhere, and no bound is left there.
    const ScreenError e = asked.coarser(1e4);
    EXPECT_GT(e.allowed_m(0), 1e6);
    EXPECT_TRUE(std::isinf(e.tolerance_px(0)));
  }
}

TEST(ScreenError, UprightNeverExceedsRigorous) {
  for (double pitch = -1.5; pitch <= 1.5; pitch += 0.1) {
    const View v = make_view({.pitch = pitch}, 800, 600);
    EXPECT_LE(pixel_scale(v, ErrorScale::Upright), pixel_scale(v, ErrorScale::Rigorous));
  }
  // METHODS 1.3: 1.39 f level, 1.93 f rigorous at 800x600, 60 degrees.
  const View v = make_view({}, 800, 600);
  EXPECT_NEAR(pixel_scale(v, ErrorScale::Upright) / v.focal_px(), 1.39, 0.005);
  EXPECT_NEAR(pixel_scale(v, ErrorScale::Rigorous) / v.focal_px(), 1.93, 0.005);
}

}  // namespace
}  // namespace arete
