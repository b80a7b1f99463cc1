#include "arete/core/view.h"

#include <cmath>

#include <gtest/gtest.h>

namespace arete {
namespace {

TEST(View, LooksNorthAndProjectsToTheCentre) {
  const View v = make_view({.eye = {100, 200, 50}}, 800, 600);
  const glm::dvec3 p = project(v, {100, 1200, 50});
  EXPECT_NEAR(p.x, 400, 1e-9);
  EXPECT_NEAR(p.y, 300, 1e-9);
  EXPECT_NEAR(p.z, 1000, 1e-9);
}

TEST(View, EastIsRightAndUpIsUp) {
  const View v = make_view({.eye = {0, 0, 0}}, 800, 600);
  EXPECT_GT(project(v, {1, 10, 0}).x, 400);
  EXPECT_GT(project(v, {0, 10, 1}).y, 300);
  const View east = make_view({.eye = {0, 0, 0}, .yaw = 1.5707963267948966}, 800, 600);
  EXPECT_GT(project(east, {10, -1, 0}).x, 400);  // south is to the right when looking east
}

TEST(View, FovyReachesTheViewportsEdge) {
  const View v = make_view({.eye = {0, 0, 0}, .fovy = 1.0}, 800, 600);
  EXPECT_NEAR(project(v, {0, 10, 10 * std::tan(0.5)}).y, 600, 1e-9);
}

TEST(View, ReversedDepthIsOneAtTheNearPlane) {
  const View v = make_view({.eye = {0, 0, 0}, .pitch = -0.5, .near_m = 2}, 640, 480);
  const glm::dvec3 p = v.forward() * 2.0;
  const glm::dvec4 c = v.clip_from_world * glm::dvec4(p, 1);
  EXPECT_NEAR(c.z / c.w, 1, 1e-12);
}

TEST(View, FrustumKeepsWhatProjectsInside) {
  const View v = make_view({.eye = {5, 6, 7}, .yaw = 0.7, .pitch = -0.3}, 640, 480);
  const auto planes = frustum_planes(v);
  int kept = 0;
  for (int i = 0; i < 1000; ++i) {
    const glm::dvec3 p{i % 10 * 7 - 30, i / 10 % 10 * 7 - 30, i / 100 * 5 - 20};
    const glm::dvec3 s = project(v, p);
    const bool inside = s.z > v.near_m && s.x > 0 && s.x < 640 && s.y > 0 && s.y < 480;
    if (inside) {
      EXPECT_TRUE(may_see(planes, p, p)) << i;
    }
    if (may_see(planes, p, p)) ++kept;
  }
  EXPECT_GT(kept, 0);
  EXPECT_LT(kept, 500);  // the control: culling does cull
}

}  // namespace
}  // namespace arete
