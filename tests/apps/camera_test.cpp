#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "arete/core/view.h"

#include "fly_camera.h"
#include "hills.h"
#include "map_camera.h"
#include "pick.h"

namespace arete::app {
namespace {

constexpr int kWidth = 800, kHeight = 600;

View random_view(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  Pose pose;
  pose.eye = {500 + 2000 * unit(random), -2000 + 1500 * unit(random), 200 + 800 * unit(random)};
  pose.yaw = 6.28 * unit(random);
  pose.pitch = -0.7 - 0.5 * unit(random);
  return make_view(pose, kWidth, kHeight);
}

glm::dvec2 random_cursor(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.1, 0.9);
  return {kWidth * unit(random), kHeight * unit(random)};
}

/// Where a point of the world appears: cursor pixels, y down.
glm::dvec2 cursor_of(const View& view, glm::dvec3 world) {
  const glm::dvec3 p = project(view, world);
  return {p.x, view.viewport_height - p.y};
}

void expect_at(const Pose& pose, glm::dvec3 world, glm::dvec2 cursor) {
  const glm::dvec2 seen = cursor_of(make_view(pose, kWidth, kHeight), world);
  EXPECT_NEAR(seen.x, cursor.x, 1e-6);
  EXPECT_NEAR(seen.y, cursor.y, 1e-6);
}

TEST(Pick, RayGoesThroughItsPixel) {
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    const View view = random_view(random);
    const glm::dvec2 cursor = random_cursor(random);
    const glm::dvec3 point = view.eye + 1234.5 * cursor_ray(view, cursor);
    expect_at(pose_of(view), point, cursor);
  }
}

TEST(Pick, GroundPointLiesOnTheGroundAndUnderTheCursor) {
  std::mt19937 random(2);
  const LeveledGround ground = hills();
  for (int i = 0; i < 100; ++i) {
    const View view = random_view(random);
    const glm::dvec2 cursor = random_cursor(random);
    const auto point = ground_along(ground, view.eye, cursor_ray(view, cursor));
    ASSERT_TRUE(point);
    EXPECT_NEAR(point->z, ground_height(ground, glm::dvec2(*point)), 1e-3);
    expect_at(pose_of(view), *point, cursor);
  }
}

TEST(Pick, NothingStandsBetweenTheEyeAndTheGroundPoint) {
  std::mt19937 random(3);
  const LeveledGround ground = hills();
  for (int i = 0; i < 20; ++i) {
    const View view = random_view(random);
    const auto point = ground_along(ground, view.eye, cursor_ray(view, random_cursor(random)));
    ASSERT_TRUE(point);
    for (int k = 1; k < 1000; ++k) {
      const glm::dvec3 p = glm::mix(view.eye, *point, k / 1000.0);
      EXPECT_GT(p.z, ground_height(ground, glm::dvec2(p)) - 0.5);
    }
  }
}

TEST(Pick, SkyHasNoGround) {
  const LeveledGround ground = hills();
  EXPECT_FALSE(ground_along(ground, {1500, -1200, 300}, glm::normalize(glm::dvec3(1, 1, 0.01))));
  EXPECT_FALSE(ground_along(ground, {1500, -1200, 300}, {0, 0, 1}));
  EXPECT_FALSE(ground_along(ground, {1500, -1200, 300}, {1, 0, 0}));
}

TEST(MapCamera, PanningKeepsTheGrabbedPointUnderTheCursor) {
  std::mt19937 random(4);
  for (int i = 0; i < 100; ++i) {
    const View view = random_view(random);
    const glm::dvec3 grabbed =
        ground_along(hills(), view.eye, cursor_ray(view, random_cursor(random))).value();
    const glm::dvec2 cursor = random_cursor(random);
    const Pose pose = panned(view, grabbed, cursor);
    expect_at(pose, grabbed, cursor);
    EXPECT_NEAR(pose.eye.z, view.eye.z, 1e-6);
  }
}

TEST(MapCamera, PanningToTheSkyStaysPut) {
  Pose pose;
  pose.eye = {1500, -1200, 300};
  pose.pitch = -0.1;
  const View view = make_view(pose, kWidth, kHeight);
  EXPECT_EQ(panned(view, {1500, 0, 0}, {400, 0}).eye, pose.eye);
}

TEST(MapCamera, ZoomKeepsThePivotAndScalesItsDistance) {
  std::mt19937 random(5);
  for (const double factor : {0.1, 0.85, 1.0, 3.0}) {
    const View view = random_view(random);
    const glm::dvec2 cursor = random_cursor(random);
    const glm::dvec3 pivot = view.eye + 700.0 * cursor_ray(view, cursor);
    const Pose pose = zoomed(view, pivot, factor);
    expect_at(pose, pivot, cursor);
    EXPECT_NEAR(glm::length(pose.eye - pivot), 700 * factor, 1e-6);
  }
}

TEST(MapCamera, TurningKeepsThePivot) {
  std::mt19937 random(6);
  for (const double yaw : {-1.0, 0.0, 0.7}) {
    for (const double pitch : {-2.0, 0.0, 0.3}) {
      const View view = random_view(random);
      const glm::dvec2 cursor = random_cursor(random);
      const glm::dvec3 pivot = view.eye + 700.0 * cursor_ray(view, cursor);
      const Pose pose = turned(view, pivot, yaw, pitch);
      expect_at(pose, pivot, cursor);
      EXPECT_LE(std::abs(pose.pitch), 89.01 * std::numbers::pi / 180);
    }
  }
}

TEST(MapCamera, HomeSeesTheWholeTerrainAndNotMuchElse) {
  const LeveledGround ground = hills();
  for (const int width : {300, 800, 1600}) {
    const View view = make_view(home_pose(ground, width / 600.0), width, 600);
    double nearest_edge = 1e9;
    for (const auto& [col, row] : {std::pair{0, 0}, {100, 0}, {0, 80}, {100, 80}}) {
      const glm::dvec3 p = project(
          view, glm::dvec3(ground.world_from_post.apply(col, row), ground.height(col, row)));
      EXPECT_GT(p.z, 0);
      nearest_edge =
          std::min({nearest_edge, p.x / width, 1 - p.x / width, p.y / 600, 1 - p.y / 600});
    }
    EXPECT_GT(nearest_edge, 0) << width;
    EXPECT_LT(nearest_edge, 0.1) << width;
  }
}

TEST(MapCamera, LiftedStaysAboveTheGround) {
  const LeveledGround ground = hills();
  Pose pose;
  pose.eye = {1000, -900, -500};
  EXPECT_DOUBLE_EQ(lifted(pose, ground, 15).eye.z,
                   ground_height(ground, glm::dvec2(pose.eye)) + 15);
  pose.eye.z = 500;
  EXPECT_DOUBLE_EQ(lifted(pose, ground, 15).eye.z, 500);
}

TEST(FlyCamera, FliesWhereItLooksAtTheSpeedOfItsHeight) {
  Pose pose;
  pose.yaw = 0.3;
  pose.pitch = -0.2;
  const View view = make_view(pose, kWidth, kHeight);
  FlyInput input;
  input.forward = 1;
  const Pose flew = flown(view, input, 0.5, 200);
  EXPECT_NEAR(glm::length(flew.eye - (pose.eye + 100.0 * view.forward())), 0, 1e-9);
  input.right = 1;  // a diagonal is no faster
  EXPECT_NEAR(glm::length(flown(view, input, 0.5, 200).eye - pose.eye), 100, 1e-9);
  EXPECT_GT(fly_speed(200, true), fly_speed(200, false));
  EXPECT_GT(fly_speed(-5, false), 0);
}

TEST(FlyCamera, DragOverTheHeightTurnsByTheFieldOfView) {
  const View view = make_view(Pose{}, kWidth, kHeight);
  FlyInput input;
  input.dragged = {kHeight, -kHeight};
  const Pose turned_right_and_up = flown(view, input, 0.02, 100);
  EXPECT_NEAR(turned_right_and_up.yaw, view.fovy, 1e-12);
  EXPECT_NEAR(turned_right_and_up.pitch, view.fovy, 1e-12);
  EXPECT_EQ(turned_right_and_up.eye, view.eye);
}

}  // namespace
}  // namespace arete::app
