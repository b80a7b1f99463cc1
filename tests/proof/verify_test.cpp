#include "arete/proof/verify.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/proof/rasteriser.h"

#include "proof/toy_engine.h"

namespace arete::proof {
namespace {

constexpr int kSide = 33;

class Verify : public ::testing::Test {
 protected:
  Verify() {
    options_.frames = 3;
    options_.width = 160;
    options_.height = 120;
    options_.draw_depth = [this](const View& v, const DrawList& list, const BlockSource& blocks) {
      return drawn_on_cpu(v, list, blocks);
    };
  }

  std::vector<float> drawn_on_cpu(const View& view, const DrawList& list,
                                  const BlockSource& blocks) const {
    mesh::Surface s;
    mesh::flatten(list, blocks, s);
    return rasterise(s, dem_.georef().world_from_post, view, {}).depth;
  }

  VerifyReport run() { return verify(engine_, dem_, path_, options_); }

  // Index of the first corner of the triangle near the middle of the list.
  static std::size_t middle(const DrawList& list) { return list.indices.size() / 2 / 3 * 3; }

  Heightfield dem_ = toy::hills(kSide, kSide);
  toy::ToyEngine engine_{dem_};
  scene::Path path_{{{.t = 0, .eye = {16, -16, 25}, .yaw = 0, .pitch = -1.5},
                     {.t = 2, .eye = {18, -15, 22}, .yaw = 0.3, .pitch = -1.4}}};
  VerifyOptions options_;
};

TEST_F(Verify, FindsNothingWrongWithEveryCellDrawn) {
  const VerifyReport r = run();
  EXPECT_TRUE(r.holds());
  EXPECT_EQ(r.frames, 3);
  EXPECT_EQ(r.max_error_px, 0);
  EXPECT_EQ(r.p999_error_px, 0);
  EXPECT_EQ(r.max_error_angular_px, 0);
  EXPECT_EQ(r.cracks, 0U);
  EXPECT_EQ(r.t_junctions, 0U);
  EXPECT_EQ(r.background_pixels, 0U);
  EXPECT_EQ(r.max_pop_px, 0);
  EXPECT_EQ(r.max_pop_share, 0);
  EXPECT_EQ(r.max_triangles, 2048U);
  EXPECT_EQ(r.mean_triangles, 2048);
  EXPECT_EQ(r.achieved_error_px, 0.25);
  EXPECT_GT(r.seconds, 0);
}

TEST_F(Verify, AsksForNothingOutsideTheView) {
  path_ = scene::Path({{.t = 0, .eye = {16, -16, 8}, .pitch = -1.5, .fovy = 0.6}});
  engine_.reach = 14;
  EXPECT_TRUE(run().holds());
  engine_.reach = 5;
  EXPECT_GT(run().cracks, 0U);
}

TEST_F(Verify, ChecksTheWholeDomainToo) {
  // Only the second refine, the one without culling, misses a triangle.
  engine_.spoil = [](DrawList& list, int refine) {
    if (refine == 1) list.batches.back().index_count -= 3;
  };
  EXPECT_EQ(run().cracks, 1U);
}

TEST_F(Verify, CatchesASwallowedTriangle) {
  engine_.spoil = [](DrawList& list, int) {
    const std::size_t i = middle(list);
    list.indices[i] = list.indices[i + 1];  // degenerate: dropped by flatten
  };
  const VerifyReport r = run();
  EXPECT_GE(r.cracks, 3U);
  EXPECT_FALSE(r.holds());
}

TEST_F(Verify, CatchesAFlippedTriangle) {
  engine_.spoil = [](DrawList& list, int) {
    std::swap(list.indices[middle(list)], list.indices[middle(list) + 1]);
  };
  EXPECT_FALSE(run().holds());
}

TEST_F(Verify, CatchesAPatchDrawnTwice) {
  engine_.spoil = [](DrawList& list, int) { list.batches.push_back(list.batches[5]); };
  EXPECT_GE(run().cracks, 3U * 64U);
}

TEST_F(Verify, CatchesAVertexOneUnitOffBetweenTwoPatches) {
  engine_.spoil = [](DrawList& list, int) {
    for (Vertex& v : list.vertices) {
      if (v.post != Post{16, 16}) continue;
      v.z = std::nextafter(v.z, 1e9F);
      return;
    }
  };
  const VerifyReport r = run();
  EXPECT_EQ(r.cracks, 4U);  // three frames and one whole domain
  EXPECT_LT(r.max_error_px, 1e-3);
  EXPECT_FALSE(r.holds());
}

TEST_F(Verify, CatchesATJunctionWithAndWithoutATriangleThatHidesIt) {
  // The first patch snaps its border vertex (8, 1) to (8, 2); its neighbour keeps it.
  const auto snap = [](DrawList& list) {
    const std::uint32_t row = toy::ToyEngine::kPatch + 1;
    const std::array<std::uint32_t, 3> border{row - 1, 2 * row - 1, 3 * row - 1};
    for (std::uint32_t i = 0; i < list.batches[0].index_count; ++i) {
      if (list.indices[i] == border[1]) list.indices[i] = border[2];
    }
    return border;
  };
  engine_.spoil = [&](DrawList& list, int) { snap(list); };
  VerifyReport r = run();
  EXPECT_EQ(r.t_junctions, 2U * 4U);
  EXPECT_EQ(r.cracks, 0U);
  EXPECT_FALSE(r.holds());

  engine_.spoil = [&](DrawList& list, int) {
    const std::array<std::uint32_t, 3> border = snap(list);
    DrawBatch closing = list.batches.back();
    closing.first_index = static_cast<std::uint32_t>(list.indices.size());
    closing.index_count = 3;
    list.indices.insert(list.indices.end(), border.begin(), border.end());
    list.batches.push_back(closing);
  };
  r = run();
  EXPECT_EQ(r.t_junctions, 2U * 4U);
  EXPECT_EQ(r.cracks, 4U);
  EXPECT_FALSE(r.holds());
}

TEST_F(Verify, CatchesAnErrorTenPercentOverTheClaim) {
  engine_.raise = 1;
  engine_.achieved_px = 100;
  engine_.claimed.error_px = std::numeric_limits<double>::infinity();
  const double reached = run().max_error_px;
  EXPECT_GT(reached, 0.5);
  engine_.claimed.error_px = reached;
  EXPECT_TRUE(run().holds());
  engine_.raise = 1.1F;
  EXPECT_FALSE(run().holds());
}

TEST_F(Verify, CatchesALieAboutTheToleranceUsed) {
  engine_.raise = 1;
  engine_.achieved_px = 100;
  options_.refine.budget.triangles = 2048;  // which may be why it is coarser
  engine_.tolerance_px = 50;
  engine_.tolerance_px = run().max_error_px;
  VerifyReport r = run();
  EXPECT_TRUE(r.holds());
  EXPECT_EQ(r.max_tolerance_px, engine_.tolerance_px);
  EXPECT_EQ(r.claims.error_px, engine_.tolerance_px);
  engine_.tolerance_px *= 0.9;
  r = run();
  EXPECT_GT(r.broken_bounds, 0);
  EXPECT_FALSE(r.holds());
}

TEST_F(Verify, CatchesALieAboutItsOwnBound) {
  engine_.raise = 1;
  engine_.claimed.error_px = 100;
  engine_.achieved_px = 100;
  engine_.achieved_px = run().max_error_px;
  EXPECT_TRUE(run().holds());
  engine_.achieved_px *= 0.9;
  EXPECT_FALSE(run().holds());
}

TEST_F(Verify, CatchesABrokenBudget) {
  const std::uint64_t bytes = run().max_vertex_bytes;
  options_.refine.budget = {2048, bytes};
  EXPECT_TRUE(run().holds());
  options_.refine.budget = {2047, bytes};
  EXPECT_EQ(run().over_budget_frames, 7);  // each frame, its later half, the whole once
  options_.refine.budget = {2048, bytes - 1};
  EXPECT_FALSE(run().holds());
}

// What nobody sees must fit the budget and conform, but its tolerance is not the flight's.
TEST_F(Verify, TheWholeDomainIsNoFrameOfTheFlight) {
  options_.refine.budget.triangles = 2048;
  engine_.spoil = [](DrawList& list, int refine) {
    if (refine == 1) list.stats.tolerance_px = list.stats.achieved_error_px = 50;
  };
  const VerifyReport r = run();
  EXPECT_EQ(r.max_tolerance_px, 1);
  EXPECT_EQ(r.achieved_error_px, 0.25);
}

TEST_F(Verify, CatchesCoarsenessThatNoBudgetAskedFor) {
  engine_.tolerance_px = 1.01;
  EXPECT_FALSE(run().holds());
  options_.refine.budget.triangles = 2048;
  EXPECT_TRUE(run().holds());
  options_.refine.budget = {std::uint64_t{1} << 20U, std::uint64_t{1} << 30U};  // nearly empty
  EXPECT_FALSE(run().holds());
}

TEST_F(Verify, AllowsTheMotionOfAChangingTolerance) {
  engine_.claimed = {.conforming = true, .error_px = 100, .pop_px = 1};
  options_.refine.budget.triangles = 2048;
  path_ = scene::Path({{.t = 0, .eye = {16, -16, 25}, .pitch = -1.5}});  // nothing else moves
  // Frame, whole, its later half, frame, its later half, ...: the later halves lie higher.
  const auto rise = [this](double to_px) {
    engine_.spoil = [to_px](DrawList& list, int refine) {
      const bool later = refine == 2 || (refine > 2 && refine % 2 == 0);
      list.stats.tolerance_px = later ? to_px : 1;
      if (!later) return;
      for (Vertex& v : list.vertices) v.z += 0.1F;
    };
    return run();
  };
  const double pop = rise(1).max_pop_px;
  EXPECT_GT(pop, 0.1);
  EXPECT_GT(rise(1 + 0.9 * pop).max_pop_share, 1);
  EXPECT_LE(rise(1 + 1.1 * pop).max_pop_share, 1);
}

TEST_F(Verify, CatchesAPopInOneFrame) {
  // Refines run: frame 0, whole domain, its later half, frame 1, its later half, ...
  engine_.claimed.error_px = engine_.achieved_px = 100;
  engine_.spoil = [](DrawList& list, int refine) {
    if (refine != 4) return;
    for (Vertex& v : list.vertices) v.z += 0.5F;
  };
  const VerifyReport r = run();
  EXPECT_GT(r.max_pop_px, 0.3);
  EXPECT_GT(r.max_pop_share, 1);
  EXPECT_FALSE(r.holds());
}

TEST_F(Verify, AllowsMotionWithinThePromise) {
  engine_.claimed = {.conforming = true, .error_px = 100, .pop_px = 1e5};
  engine_.spoil = [](DrawList& list, int refine) {
    for (Vertex& v : list.vertices) v.z += 0.001F * static_cast<float>(refine);
  };
  const VerifyReport r = run();
  EXPECT_GT(r.max_pop_px, 0);
  EXPECT_GT(r.max_pop_share, 0);
  EXPECT_TRUE(r.holds());
}

TEST_F(Verify, CatchesALeakInThePicture) {
  options_.draw_depth = [this](const View& v, const DrawList& list, const BlockSource& blocks) {
    DrawList holed = list;
    holed.indices[middle(list)] = holed.indices[middle(list) + 1];
    return drawn_on_cpu(v, holed, blocks);
  };
  const VerifyReport r = run();
  EXPECT_GT(r.background_pixels, 0U);
  EXPECT_EQ(r.cracks, 0U);
  EXPECT_FALSE(r.holds());
}

TEST_F(Verify, HoldsWhatWasNotClaimed) {
  engine_.claimed = {.conforming = false,
                     .error_px = std::numeric_limits<double>::infinity(),
                     .pop_px = std::numeric_limits<double>::infinity()};
  engine_.achieved_px = 100;
  engine_.raise = 3;
  engine_.spoil = [](DrawList& list, int refine) {
    list.batches.resize(list.batches.size() - static_cast<std::size_t>(refine % 3));
  };
  EXPECT_TRUE(run().holds());
}

TEST_F(Verify, DumpsEachFrameForOtherPrograms) {
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / "arete_verify_dump";
  std::filesystem::remove_all(folder);
  options_.dump = folder;
  run();
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 6);
  std::ifstream in(folder / "frame_00002.ply", std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  EXPECT_NE(text.find("element vertex 1089\n"), std::string::npos);
  EXPECT_NE(text.find("element face 2048\n"), std::string::npos);
  std::filesystem::remove_all(folder);
}

TEST_F(Verify, StopsWhenProgressThrows) {
  options_.progress = [](double) { throw Error(ErrorCode::Cancelled, "stop"); };
  EXPECT_THROW(run(), Error);
}

TEST_F(Verify, OpenGlLeavesNoBackground) {
  options_.draw_depth = nullptr;
  VerifyReport r;
  try {
    r = run();
  } catch (const Error& e) {
    if (e.code() != ErrorCode::Unsupported) throw;
    GTEST_SKIP() << e.what();
  }
  EXPECT_EQ(r.background_pixels, 0U);
  EXPECT_TRUE(r.holds());
}

TEST_F(Verify, OpenGlDrawsTheCpusPicture) {
  // I10, and the leak check has something to look at.
  std::unique_ptr<GlPicture> gl;
  try {
    gl = std::make_unique<GlPicture>(dem_);
  } catch (const Error& e) {
    GTEST_SKIP() << e.what();
  }
  const View view = make_view(path_.at(0.5), 160, 120);
  DrawList list;
  engine_.refine(view, {}, list);
  const std::vector<float> got = gl->depth(view, list, engine_);
  const std::vector<float> expected = drawn_on_cpu(view, list, engine_);
  ASSERT_EQ(got.size(), expected.size());
  int differing = 0;
  for (std::size_t i = 0; i < got.size(); ++i) {
    differing += static_cast<int>(std::abs(got[i] - expected[i]) > 0.01F * expected[i]);
  }
  EXPECT_LE(differing, 20);
  EXPECT_GT(*std::ranges::max_element(got), 0);
}

}  // namespace
}  // namespace arete::proof
