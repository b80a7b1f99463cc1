#include "arete/scene/path.h"

#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "arete/core/error.h"

namespace arete::scene {
namespace {

constexpr double kPi = std::numbers::pi;

std::vector<Keyframe> random_keyframes(int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> metres(-1000, 1000), angle(-kPi, kPi), step(0.2, 2);
  std::vector<Keyframe> keyframes;
  for (int i = 0; i < count; ++i) {
    Keyframe k;
    k.t = i == 0 ? 0 : keyframes.back().t + step(random);
    k.eye = {metres(random), metres(random), metres(random)};
    k.yaw = angle(random);
    k.pitch = angle(random) / 4;
    k.fovy = 0.5 + std::abs(angle(random)) / 4;
    keyframes.push_back(k);
  }
  return keyframes;
}

double angle_between(double a, double b) {
  return std::abs(std::remainder(a - b, 2 * kPi));
}

// The largest change of velocity within h seconds, over everything that moves. A C1 path makes it
// vanish with h.
double largest_kink(const Path& path, double h) {
  double kink = 0;
  for (const Keyframe& k : path.keyframes()) {
    const double t = k.t - path.keyframes().front().t;
    if (t < h || t + h > path.duration()) continue;
    const Pose a = path.at(t - h);
    const Pose b = path.at(t);
    const Pose c = path.at(t + h);
    kink = std::max(kink, glm::length((c.eye - b.eye) - (b.eye - a.eye)) / h);
    const double turn =
        std::remainder(c.yaw - b.yaw, 2 * kPi) - std::remainder(b.yaw - a.yaw, 2 * kPi);
    kink = std::max(kink, 100 * std::abs(turn) / h);
  }
  return kink;
}

TEST(Path, PassesThroughItsKeyframes) {
  const Path path(random_keyframes(20, 1));
  for (const Keyframe& k : path.keyframes()) {
    const Pose p = path.at(k.t);
    EXPECT_LT(glm::distance(p.eye, k.eye), 1e-9);
    EXPECT_LT(angle_between(p.yaw, k.yaw), 1e-9);
    EXPECT_NEAR(p.pitch, k.pitch, 1e-12);
    EXPECT_NEAR(p.fovy, k.fovy, 1e-12);
  }
}

TEST(Path, VelocityIsContinuous) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Path path(random_keyframes(20, seed));
    EXPECT_LT(largest_kink(path, 1e-5), 0.02 * largest_kink(path, 1e-2) + 0.5);
  }
}

TEST(Path, TheKinkCheckerSeesAKink) {
  std::vector<Keyframe> straight(40);  // a corner made of keyframes that are nearly linear
  for (int i = 0; i < 40; ++i) {
    straight[static_cast<std::size_t>(i)].t = i < 20 ? i : 19 + (i - 19) * 1e-4;
    straight[static_cast<std::size_t>(i)].eye.x = std::abs(i - 20) * 100.0;
  }
  EXPECT_GT(largest_kink(Path(straight), 1e-5), 1000);
}

TEST(Path, YawTakesTheShorterWay) {
  Keyframe a, b;
  a.yaw = 170 * kPi / 180;
  b.yaw = -170 * kPi / 180;
  b.t = 1;
  const Path path({a, b});
  for (double t = 0; t <= 1; t += 0.05) EXPECT_GT(std::abs(path.at(t).yaw), 169.9 * kPi / 180);
  EXPECT_NEAR(std::abs(path.at(0.5).yaw), kPi, 1e-9);
}

TEST(Path, EqualNeighboursHover) {
  auto keyframes = random_keyframes(6, 4);
  keyframes[3].eye = keyframes[2].eye;
  const Path path(keyframes);
  for (double u = 0; u <= 1; u += 0.1) {
    const double t = keyframes[2].t + u * (keyframes[3].t - keyframes[2].t);
    EXPECT_LT(glm::distance(path.at(t).eye, keyframes[2].eye), 1e-9);
  }
}

TEST(Path, IsClampedToItsEnds) {
  const Path path(random_keyframes(5, 5));
  EXPECT_EQ(path.at(-3).eye, path.at(0).eye);
  EXPECT_EQ(path.at(1e9).eye, path.at(path.duration()).eye);
  const Path still({Keyframe{3, {1, 2, 3}, 0.5, 0.1, 1}});
  EXPECT_EQ(still.duration(), 0);
  EXPECT_EQ(still.at(7).eye, glm::dvec3(1, 2, 3));
}

class PathFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* const test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(::testing::TempDir()) /
              fmt::format("arete_path_{}_{}", test->name(), ::getpid());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path write(const std::string& text) const {
    const auto file = folder_ / "p.json";
    std::ofstream(file) << text;
    return file;
  }
  std::filesystem::path folder_;
};

TEST_F(PathFile, RoundTrips) {
  const Path path(random_keyframes(30, 6));
  const auto file = folder_ / "round.json";
  write_path(path, file);
  const Path back = read_path(file);
  ASSERT_EQ(back.keyframes().size(), path.keyframes().size());
  for (std::size_t i = 0; i < path.keyframes().size(); ++i) {
    const Keyframe& a = path.keyframes()[i];
    const Keyframe& b = back.keyframes()[i];
    EXPECT_EQ(a.t, b.t);
    EXPECT_EQ(a.eye, b.eye);
    EXPECT_NEAR(a.yaw, b.yaw, 1e-14);
    EXPECT_NEAR(a.pitch, b.pitch, 1e-14);
    EXPECT_NEAR(a.fovy, b.fovy, 1e-14);
  }
}

TEST_F(PathFile, ReadsDegrees) {
  const Path path = read_path(
      write(R"({"keyframes": [{"t": 0, "eye": [1, 2, 3], "yaw": 90, "pitch": -45, "fovy": 30}]})"));
  EXPECT_NEAR(path.at(0).yaw, kPi / 2, 1e-12);
  EXPECT_NEAR(path.at(0).pitch, -kPi / 4, 1e-12);
  EXPECT_NEAR(path.at(0).fovy, kPi / 6, 1e-12);
}

TEST_F(PathFile, BadFilesAreOneLineErrors) {
  const char* const bad[] = {
      "",
      "{",
      "[]",
      "3",
      R"({"keyframes": []})",
      R"({"keyframes": 3})",
      R"({"keyframes": [3]})",
      R"({"keyframes": [{"t": 0}]})",
      R"({"keyframes": [{"t": 0, "eye": [1, 2], "yaw": 0, "pitch": 0}]})",
      R"({"keyframes": [{"t": 0, "eye": [1, 2, "x"], "yaw": 0, "pitch": 0}]})",
      R"({"keyframes": [{"t": 0, "eye": [1, 2, 1e999], "yaw": 0, "pitch": 0}]})",
      R"({"keyframes": [{"t": 0, "eye": [1, 2, 3], "yaw": 0, "pitch": 91}]})",
      R"({"keyframes": [{"t": 0, "eye": [1, 2, 3], "yaw": 0, "pitch": 0, "fovy": 180}]})",
      R"({"keyframes": [{"t": "0", "eye": [1, 2, 3], "yaw": 0, "pitch": 0}]})",
      R"({"keyframes": [{"t": 1, "eye": [1, 2, 3], "yaw": 0, "pitch": 0},
                        {"t": 1, "eye": [1, 2, 3], "yaw": 0, "pitch": 0}]})"};
  for (const char* text : bad) {
    SCOPED_TRACE(text);
    try {
      read_path(write(text));
      ADD_FAILURE();
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::InvalidInput);
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    }
  }
}

TEST_F(PathFile, MissingFilesAndFoldersAreErrors) {
  EXPECT_THROW(read_path(folder_ / "none.json"), Error);
  EXPECT_THROW(read_path(folder_), Error);
  EXPECT_THROW(write_path(Path({Keyframe{}}), folder_ / "no" / "p.json"), Error);
}

}  // namespace
}  // namespace arete::scene
