// soar's strip is the leaves of the bin-tree, whatever the view, the options and what is missing.
#include <cmath>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "arete/lod/bintree/strip.h"
#include "arete/lod/engine.h"

#include "lod/built_terrain.h"
#include "lod/plain_refinement.h"

namespace arete::lod::bintree {
namespace {

View random_view(const Heightfield& dem, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const glm::dvec2 plan = dem.georef().world_from_post.apply(
      (1.2 * unit(random) - 0.1) * dem.cols(), (1.2 * unit(random) - 0.1) * dem.rows());
  return make_view({.eye = {plan, 300 + 2000 * unit(random) * unit(random)},
                    .yaw = 6.3 * unit(random),
                    .pitch = -1.5 * unit(random),
                    .near_m = 1},
                   320, 240);
}

Heightfield turned_dem() {
  const Heightfield dem = rough_dem(90, 131, 5, 0);
  Georef georef;
  georef.world_from_post.m = {20, 15, 0, 15, -20, 0};
  Heightfield out(dem.cols(), dem.rows(), georef);
  for (int r = 0; r < dem.rows(); ++r)
    for (int c = 0; c < dem.cols(); ++c) out[{c, r}] = dem[{c, r}];
  return out;
}

std::vector<Heightfield> dems() {
  std::vector<Heightfield> out;
  out.push_back(rough_dem(129, 97, 1, 0));
  out.push_back(rough_dem(150, 131, 2, 0.2));
  out.push_back(rough_dem(300, 3, 3, 0));
  out.push_back(rough_dem(2, 2, 4, 0));
  out.push_back(turned_dem());
  return out;
}

/// Twice the area of the triangle in cells, positive where it runs counter-clockwise from above.
int area(const mesh::Surface& surface, std::size_t triangle) {
  std::array<Post, 3> p;
  for (std::size_t k = 0; k < 3; ++k)
    p[k] = surface.vertices[surface.indices[3 * triangle + k]].post;
  return (p[2].col - p[0].col) * (p[1].row - p[0].row) -
         (p[1].col - p[0].col) * (p[2].row - p[0].row);
}

std::size_t clockwise(const mesh::Surface& surface) {
  std::size_t count = 0;
  for (std::size_t t = 0; t < surface.triangles(); ++t) count += area(surface, t) > 0 ? 0 : 1;
  return count;
}

TEST(SoarStrip, IsTheLeavesCounterClockwise) {
  std::mt19937_64 random(7);
  for (Heightfield& dem : dems()) {
    const RecordedTerrain recorded(std::move(dem));
    const auto engine = find_engine("soar").open(recorded.terrain(), {});
    Ground ground(recorded.terrain(), {});
    AllRecords records(recorded.terrain(), Delta::Exact);
    DrawList list;
    mesh::Surface surface;
    for (int i = 0; i < 40; ++i) {
      SCOPED_TRACE(fmt::format("{} columns, view {}", recorded.dem().cols(), i));
      const View view = random_view(recorded.dem(), random);
      const RefineOptions options{.tolerance_px = 0.2 + i % 5,
                                  .scale = i % 3 == 0 ? ErrorScale::Angular : ErrorScale::Upright,
                                  .cull = i % 2 == 0};
      const Criterion criterion(view, {view, options.tolerance_px, options.scale});
      const PlainRefinement plain(records, ground, criterion, options.cull);
      engine->refine(view, options, list);
      mesh::flatten(list, *engine, surface);
      EXPECT_EQ(sorted_triangles(surface), plain.leaves);
      EXPECT_EQ(list.stats.triangles, plain.leaves.size());
      EXPECT_EQ(clockwise(surface), 0U);
      for (const mesh::SurfaceVertex& v : surface.vertices)
        ASSERT_EQ(v.z, static_cast<float>(ground.z_of(records[v.post])));
    }
  }
}

TEST(SoarStrip, ChecksCatchAWrongStrip) {
  const RecordedTerrain recorded(rough_dem(129, 97, 1, 0));
  const auto engine = find_engine("soar").open(recorded.terrain(), {});
  DrawList list;
  mesh::Surface right;
  engine->refine(flight_view(0.3), {}, list);
  mesh::flatten(list, *engine, right);
  ASSERT_GT(right.triangles(), 100U);

  DrawList turned = list;  // without the vertex that turns the winding
  turned.indices.erase(turned.indices.begin());
  --turned.batches[0].index_count;
  mesh::Surface surface;
  mesh::flatten(turned, *engine, surface);
  EXPECT_EQ(clockwise(surface), surface.triangles());

  DrawList wrong = list;
  wrong.indices[wrong.indices.size() / 2] = wrong.indices[3];
  mesh::flatten(wrong, *engine, surface);
  EXPECT_NE(sorted_triangles(surface), sorted_triangles(right));
}

// Two vertices at once, bit by bit as each alone.
TEST(PairTest, SaysWhatTheCriterionSays) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  const RecordedTerrain recorded(turned_dem());
  const Ground ground(recorded.terrain(), {});
  int selected_a = 0, selected_b = 0;
  constexpr int kTrials = 100'000;
  for (int i = 0; i < kTrials / 100; ++i) {
    const View view = random_view(recorded.dem(), random);
    const Criterion criterion(
        view, ScreenError(view, 3 * unit(random)).coarser(i % 2 == 0 ? 1 : 20 * unit(random) + 1));
    const PairTest test(ground, criterion);
    for (int k = 0; k < 100; ++k) {
      const auto post = [&] {
        return Post{static_cast<int>(random() % 91), static_cast<int>(random() % 132)};
      };
      const auto record = [&] {
        return Record{static_cast<int>(random() % 4000),
                      random() % 20 == 0 ? Code{0} : code_up(std::exp(8 * unit(random) - 5)),
                      random() % 50 == 0 ? kInfinite : code_up(6000 * unit(random) * unit(random))};
      };
      const Post a = post(), b = post();
      const Record ra = record(), rb = random() % 9 == 0 ? Record{} : record();
      const PairTest::Answers both = test(a, ra, b, rb);
      const Ball ball_a = ground.ball(a, ra), ball_b = ground.ball(b, rb);
      ASSERT_EQ(both.a, criterion.selected(ball_a));
      ASSERT_EQ(both.b, criterion.selected(ball_b));
      ASSERT_EQ(both.z_a, static_cast<float>(ball_a.centre.z));
      ASSERT_EQ(both.z_b, static_cast<float>(ball_b.centre.z));
      selected_a += both.a ? 1 : 0;
      selected_b += both.b ? 1 : 0;
    }
  }
  for (const int selected : {selected_a, selected_b}) {  // the control: both answers occur
    EXPECT_GT(selected, kTrials / 10);
    EXPECT_LT(selected, kTrials - kTrials / 10);
  }
}

// Pages come in with frames that wait and stay away from those that do not: no thread, no chance.
TEST(SoarMissing, ConformsAndStaysBoundedWhateverIsThere) {
  const RecordedTerrain recorded(rough_dem(257, 200, 9, 0.05));
  const RecordPages::Options few{.budget_bytes = 40 * kRecordPageBytes, .prefetch = Prefetch::Off};
  const auto engine =
      find_engine("soar").open(recorded.terrain(), {{"pages", "40"}, {"prefetch", "off"}});
  Ground ground(recorded.terrain(), few);
  std::mt19937_64 random(5);
  DrawList list;
  mesh::Surface surface;
  std::uint64_t late = 0, cracks_without_presence = 0;
  for (int i = 0; i < 60; ++i) {
    const RefineOptions wait{.tolerance_px = 3};
    const RefineOptions defer{
        .tolerance_px = 0.7, .on_missing = OnMissing::Defer, .cull = i % 2 == 0};
    const View here = random_view(recorded.dem(), random);
    const View there = random_view(recorded.dem(), random);
    engine->refine(here, wait, list);
    engine->refine(there, defer, list);
    late += list.stats.late_blocks;
    mesh::flatten(list, *engine, surface);
    const auto report = mesh::check_surface(surface, recorded.dem(), defer.cull ? &there : nullptr);
    ASSERT_EQ(report.cracks() + report.t_junctions, 0U) << i;
    EXPECT_GE(list.stats.achieved_error_px, list.stats.tolerance_px);

    // The planted fault: a walk that does not ask for ancestors.
    DrawList loose;
    for (const auto& [view, options] : {std::pair(here, wait), std::pair(there, defer)}) {
      const ScreenError error(view, options.tolerance_px, options.scale);
      const Criterion criterion(view, error);
      Strip strip(loose);
      ground.pages().begin_frame();
      Walk<Strip> walk(ground, {criterion, error, options}, strip);
      walk.refine_all();
      strip.finish();
    }
    loose.batches.push_back({.index_count = static_cast<std::uint32_t>(loose.indices.size()),
                             .topology = Topology::Strip});
    mesh::flatten(loose, *engine, surface);
    const auto without = mesh::check_surface(surface, recorded.dem(), nullptr);
    cracks_without_presence += without.overlaps + without.t_junctions;
  }
  EXPECT_GT(late, 1000U);
  EXPECT_GT(cracks_without_presence, 0U);
}

TEST(SoarBudget, IsKeptAndFramesAreTheSameWhateverCameBefore) {
  const RecordedTerrain recorded(rough_dem(257, 193, 1, 0));
  for (const char* morph : {"false", "true"}) {
    SCOPED_TRACE(morph);
    const auto open = [&] {
      return find_engine("soar").open(recorded.terrain(), {{"morph", morph}});
    };
    const auto flying = open();
    DrawList a, b;
    int bound = 0;
    for (int i = 0; i < 40; ++i) {
      const View view = flight_view(i / 40.0);
      RefineOptions options{.tolerance_px = 1};
      if (i % 5 != 4) options.budget.triangles = 200 + static_cast<std::uint64_t>(i % 3) * 900;
      flying->refine(view, options, a);
      open()->refine(view, options, b);
      EXPECT_EQ(a.indices, b.indices);
      EXPECT_EQ(a.stats.tolerance_px, b.stats.tolerance_px);
      EXPECT_LE(a.stats.triangles, options.budget.triangles);
      if (a.stats.tolerance_px > 1) ++bound;
    }
    EXPECT_GT(bound, 10);
    EXPECT_LT(bound, 33);
  }
}

TEST(SoarBounds, NoBoundIsSaidWhereNoneIsKnown) {
  const BuiltTerrain terrain(rough_dem(65, 65, 3, 0));
  const auto opened = terrain.open();
  DrawList list;
  const auto soar = [&](const Params& params) {
    const auto engine = find_engine("soar").open(*opened, params);
    engine->refine(flight_view(0.3), {.tolerance_px = 2}, list);
    return list.stats.achieved_error_px;
  };
  EXPECT_EQ(soar({}), 2);
  EXPECT_TRUE(std::isfinite(list.batches[0].error));
  EXPECT_TRUE(std::isinf(soar({{"morph", "true"}})));
  EXPECT_TRUE(std::isinf(list.batches[0].error));
}

}  // namespace
}  // namespace arete::lod::bintree
