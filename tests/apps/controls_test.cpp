#include "controls.h"

#include <gtest/gtest.h>

#include "hills.h"
#include "map_camera.h"
#include "pick.h"

namespace arete::app {
namespace {

constexpr FrameSize kSize{800, 600};

glm::dvec3 ground_under(const Controls& controls, const LeveledGround& ground, glm::dvec2 cursor) {
  const View view = make_view(controls.pose(), kSize.width, kSize.height);
  return ground_along(ground, view.eye, cursor_ray(view, cursor)).value();
}

class ControlsTest : public testing::Test {
 protected:
  /// One frame with the cursor moved to here.
  void frame(Input input, glm::dvec2 cursor) {
    input.moved = cursor - cursor_;
    input.cursor = cursor_ = cursor;
    input.seconds = 0.02;
    controls_.update(input, kSize);
  }

  LeveledGround ground_ = hills();
  Controls controls_{ground_, home_pose(ground_, 4.0 / 3)};
  glm::dvec2 cursor_{400, 300};
};

TEST_F(ControlsTest, LeftDragCarriesTheGround) {
  const glm::dvec3 grabbed = ground_under(controls_, ground_, cursor_);
  Input drag;
  drag.left = true;
  for (int i = 1; i <= 10; ++i) {
    frame(drag, {400 + 15 * i, 300 + 7 * i});
  }
  EXPECT_LT(glm::length(ground_under(controls_, ground_, cursor_) - grabbed), 0.5);
}

TEST_F(ControlsTest, WheelZoomsToTheCursor) {
  const glm::dvec2 cursor{250, 350};
  frame({}, cursor);
  const glm::dvec3 aimed = ground_under(controls_, ground_, cursor);
  const double before = glm::length(controls_.pose().eye - aimed);
  Input wheel;
  wheel.wheel = 1;
  for (int i = 0; i < 8; ++i) {
    frame(wheel, cursor);
  }
  EXPECT_LT(glm::length(controls_.pose().eye - aimed), 0.4 * before);
  EXPECT_LT(glm::length(ground_under(controls_, ground_, cursor) - aimed), 1.0);
}

TEST_F(ControlsTest, MiddleDragTurnsAboutTheGrabbedGround) {
  const glm::dvec3 grabbed = ground_under(controls_, ground_, cursor_);
  const double yaw = controls_.pose().yaw;
  Input drag;
  drag.middle = true;
  for (int i = 1; i <= 10; ++i) {
    frame(drag, {400 + 10 * i, 300});
  }
  EXPECT_NE(controls_.pose().yaw, yaw);
  EXPECT_LT(glm::length(ground_under(controls_, ground_, {400, 300}) - grabbed), 1.0);
}

TEST_F(ControlsTest, NothingGoesBelowTheGround) {
  Input wheel;
  wheel.wheel = 20;
  for (int i = 0; i < 50; ++i) {
    frame(wheel, cursor_);
    const glm::dvec3 eye = controls_.pose().eye;
    ASSERT_GT(eye.z, ground_height(ground_, glm::dvec2(eye)));
  }
}

TEST_F(ControlsTest, DoubleClickGlidesCloserAndStops) {
  const glm::dvec3 aimed = ground_under(controls_, ground_, cursor_);
  const double before = glm::length(controls_.pose().eye - aimed);
  Input click;
  click.double_click = click.left = true;
  frame(click, cursor_);
  for (int i = 0; i < 60; ++i) {
    frame({}, cursor_);
  }
  EXPECT_NEAR(glm::length(controls_.pose().eye - aimed), 0.3 * before, 0.02 * before);
  const Pose rested = controls_.pose();
  frame({}, cursor_);
  EXPECT_EQ(controls_.pose().eye, rested.eye);
}

TEST_F(ControlsTest, FlyKeysMoveOnlyInFlyMode) {
  const glm::dvec3 start = controls_.pose().eye;
  Input forward;
  forward.fly.forward = 1;
  frame(forward, cursor_);
  EXPECT_EQ(controls_.pose().eye, start);
  controls_.toggle_fly();
  EXPECT_EQ(controls_.mode(), ControlMode::Fly);
  frame(forward, cursor_);
  EXPECT_NE(controls_.pose().eye, start);
}

TEST_F(ControlsTest, IdleFramesKeepTheCamera) {
  const Pose start = controls_.pose();
  for (int i = 0; i < 5; ++i) {
    frame({}, {300 + 20 * i, 200});
  }
  EXPECT_EQ(controls_.pose().eye, start.eye);
  EXPECT_EQ(controls_.pose().yaw, start.yaw);
}

}  // namespace
}  // namespace arete::app
