#include <algorithm>
#include <cmath>
#include <numbers>
#include <ostream>

#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/scene/path.h"

namespace arete::scene {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFrame = 1.0 / 60;

struct Case {
  const char* name;
  int cols, rows;
  double spacing;
  double relief;      // metres, peak to valley
  double wavelength;  // posts
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.name;
}

Ground ground_of(const Case& c) {
  Ground g;
  g.cols = c.cols;
  g.rows = c.rows;
  g.world_from_post.m = {c.spacing, 0, 0, 0, -c.spacing, 0};
  g.z_min = -c.relief / 2;
  g.z_max = c.relief / 2;
  g.height = [c](double col, double row) {
    const double x = std::clamp(col, 0.0, c.cols - 1.0) * 2 * kPi / c.wavelength;
    const double y = std::clamp(row, 0.0, c.rows - 1.0) * 2 * kPi / c.wavelength;
    return c.relief / 2 * std::sin(x) * std::cos(y);
  };
  return g;
}

double height_above(const Ground& g, const Pose& pose) {
  const glm::dvec2 post = g.world_from_post.inverse({pose.eye.x, pose.eye.y});
  return pose.eye.z - g.height(post.x, post.y);
}

double lowest(const Path& path, const Ground& g) {
  double low = 1e300;
  for (double t = 0; t <= path.duration(); t += kFrame) {
    low = std::min(low, height_above(g, path.at(t)));
  }
  return low;
}

// Share of the time with a height above ground in [low, high].
double share(const Path& path, const Ground& g, double low, double high) {
  int inside = 0, all = 0;
  for (double t = 0; t < path.duration(); t += kFrame, ++all) {
    const double h = height_above(g, path.at(t));
    inside += h >= low && h <= high ? 1 : 0;
  }
  return static_cast<double>(inside) / all;
}

class Flights : public ::testing::TestWithParam<Case> {};

TEST_P(Flights, StayAboveTheGround) {
  const Ground g = ground_of(GetParam());
  for (const char* name : {"flyover", "orbit", "descent"}) {
    SCOPED_TRACE(name);
    EXPECT_GT(lowest(make_path(name, g), g), GetParam().spacing);
  }
}

TEST_P(Flights, MoveWithoutJumps) {
  const Ground g = ground_of(GetParam());
  for (const char* name : {"flyover", "orbit", "descent"}) {
    SCOPED_TRACE(name);
    const Path path = make_path(name, g);
    double fastest = 0, worst = 0;
    glm::dvec3 before = (path.at(kFrame).eye - path.at(0).eye) / kFrame;
    for (double t = kFrame; t + kFrame <= path.duration(); t += kFrame) {
      const glm::dvec3 velocity = (path.at(t + kFrame).eye - path.at(t).eye) / kFrame;
      worst = std::max(worst, glm::length(velocity - before));
      fastest = std::max(fastest, glm::length(velocity));
      before = velocity;
    }
    EXPECT_TRUE(std::isfinite(fastest));
    EXPECT_LT(worst, 0.2 * fastest);
  }
}

TEST_P(Flights, AreClosedWhereTheySayRound) {
  const Ground g = ground_of(GetParam());
  for (const char* name : {"flyover", "orbit"}) {
    const Path path = make_path(name, g);
    EXPECT_TRUE(path.closed());
    EXPECT_NEAR(path.duration(), 60, 1e-9);
    EXPECT_LT(glm::distance(path.at(0).eye, path.at(60).eye), 1e-6);
  }
}

TEST_P(Flights, TheFlyoverKeepsToTheMiddleOfTheBox) {
  const Ground g = ground_of(GetParam());
  const Path path = make_path("flyover", g);
  for (double t = 0; t < 60; t += kFrame) {
    const glm::dvec3 eye = path.at(t).eye;
    const glm::dvec2 post = g.world_from_post.inverse({eye.x, eye.y});
    const double u = std::abs(post.x / std::max(g.cols - 1, 1) - 0.5 * (g.cols > 1));
    const double v = std::abs(post.y / std::max(g.rows - 1, 1) - 0.5 * (g.rows > 1));
    ASSERT_LE(std::max(u, v), 0.4005) << t;
  }
}

// Lands so wide and smooth that the three bands of heights are apart and can be kept.
class RoomyFlights : public Flights {};

TEST_P(RoomyFlights, TheFlyoverSpendsItsTimeInThreeBands) {
  const Ground g = ground_of(GetParam());
  const Path path = make_path("flyover", g);
  const double s = GetParam().spacing;
  const double extent = std::max(g.cols - 1, g.rows - 1) * s;
  EXPECT_NEAR(share(path, g, 3 * s, 10 * s), 0.25, 0.05);
  EXPECT_NEAR(share(path, g, 0.01 * extent, 0.05 * extent), 0.5, 0.1);
  EXPECT_NEAR(share(path, g, 0.24 * extent, 0.36 * extent), 0.25, 0.05);
}

TEST_P(Flights, TheFlyoverHoversAndTurnsAround) {
  const Ground g = ground_of(GetParam());
  const Path path = make_path("flyover", g);
  int still = 0;
  double turned = 0;
  for (double t = 0; t + kFrame < 60; t += kFrame) {
    const Pose a = path.at(t);
    const Pose b = path.at(t + kFrame);
    if (glm::distance(a.eye, b.eye) > 1e-9 * GetParam().spacing) continue;
    ++still;
    turned += std::abs(std::remainder(b.yaw - a.yaw, 2 * kPi));
  }
  EXPECT_NEAR(still * kFrame, 3, 0.3);
  EXPECT_NEAR(turned, kPi, 0.25);
}

constexpr Case kRoomy[] = {{"hills", 1201, 1201, 30, 400, 150},
                           {"alps", 2001, 1001, 90, 3000, 120},
                           {"flat", 4097, 4097, 1, 0, 100},
                           {"globe", 3601, 1801, 10000, 9000, 50},
                           {"huge", 200001, 100001, 1, 3000, 9000}};
constexpr Case kTight[] = {{"rough", 1001, 1001, 10, 200, 30}, {"spikes", 513, 513, 10, 2000, 8},
                           {"smallest", 2, 2, 1, 3, 2},        {"small", 9, 5, 10000, 8000, 6},
                           {"thin", 1000, 3, 30, 300, 80},     {"row", 50, 1, 30, 10, 20},
                           {"post", 1, 1, 30, 0, 20}};

std::string name_of(const ::testing::TestParamInfo<Case>& tested) {
  return tested.param.name;
}

INSTANTIATE_TEST_SUITE_P(Roomy, Flights, ::testing::ValuesIn(kRoomy), name_of);
INSTANTIATE_TEST_SUITE_P(Tight, Flights, ::testing::ValuesIn(kTight), name_of);
INSTANTIATE_TEST_SUITE_P(Roomy, RoomyFlights, ::testing::ValuesIn(kRoomy), name_of);

TEST(NamedFlights, CheckersSeeABadFlight) {
  const Ground g = ground_of(kRoomy[0]);
  std::vector<Keyframe> straight(2);
  straight[0].eye = {100, -100, 50};
  straight[1].eye = {30000, -30000, 50};
  straight[1].t = 60;
  const Path path(straight);
  EXPECT_LT(lowest(path, g), 0);
  EXPECT_LT(share(path, g, 90, 300), 0.9);
}

TEST(NamedFlights, TheOrbitLooksAtTheCentre) {
  const Ground g = ground_of(kRoomy[1]);
  const Path path = make_path("orbit", g);
  const glm::dvec2 plan = g.world_from_post.apply((g.cols - 1) * 0.5, (g.rows - 1) * 0.5);
  const glm::dvec3 centre(plan, g.height((g.cols - 1) * 0.5, (g.rows - 1) * 0.5));
  for (double t = 0; t < 60; t += 0.37) {
    const View view = make_view(path.at(t), 800, 600);
    EXPECT_GT(glm::dot(view.forward(), glm::normalize(centre - view.eye)), std::cos(0.01));
  }
}

TEST(NamedFlights, TheDescentEndsNearTheGround) {
  const Ground g = ground_of(kRoomy[0]);
  const Path path = make_path("descent", g);
  EXPECT_GT(height_above(g, path.at(0)), 1000 * 30);
  EXPECT_LT(height_above(g, path.at(path.duration())), 10 * 30);
}

TEST(NamedFlights, AnUnknownNameListsTheKnownOnes) {
  const Ground g = ground_of(kRoomy[0]);
  try {
    make_path("flyby", g);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::Usage);
    EXPECT_NE(std::string(e.what()).find("flyover"), std::string::npos);
  }
  try {
    make_path("none.json", g);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::NotFound);
  }
}

}  // namespace
}  // namespace arete::scene
