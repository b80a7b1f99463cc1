#include "arete/lod/geomipmap/geomipmap.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/lod/level_field.h"
#include "arete/mesh/surface.h"

#include "lod/built_terrain.h"

namespace arete::lod {
namespace {

class Geomipmap : public testing::Test {
 protected:
  BuiltTerrain terrain_{rough_dem(257, 193, 1, 0.1), {{"patch", "17"}}};
  std::unique_ptr<store::Terrain> opened_ = terrain_.open();
};

TEST_F(Geomipmap, FieldKeepsItsConstraints) {
  const PatchTable table(*opened_, 4);
  LevelField field(table, opened_->manifest().quantum_m);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int k = 0; k < 200; ++k) {
    const View view = flight_view(unit(random));
    const ScreenError error(view, 0.3 + 5 * unit(random));
    field.solve(view.eye, error);
    for (int p = 0; p < table.size(); ++p) {
      if (!table.drawable(p)) continue;
      EXPECT_LE(field.error(p), error.allowed_m(field.distance(p)) * (1 + 1e-5) + 1e-9);
      for (const Side q : kAllSides) {
        const int n = table.neighbour(p, q);
        if (n < 0) continue;
        EXPECT_LE(std::abs(field.level(p) - field.level(n)), 1.0F);
        EXPECT_LE(std::abs(std::floor(field.level(p)) - std::floor(field.level(n))), 1.0F);
      }
    }
  }
}

// Height of the drawn surface at the posts of its vertices.
std::map<std::pair<int, int>, float> heights(Engine& engine, const View& view) {
  DrawList list;
  engine.refine(view, {.cull = false}, list);
  mesh::Surface surface;
  mesh::flatten(list, engine, surface);
  std::map<std::pair<int, int>, float> out;
  for (const auto& v : surface.vertices) out[{v.post.col, v.post.row}] = v.z;
  return out;
}

TEST_F(Geomipmap, NothingPops) {
  const auto engine = geomipmap::open(*opened_, {{"patch", "17"}});
  const double step = 1e-4;  // of the path: half a metre
  double worst = 0;
  for (int k = 0; k < 60; ++k) {
    const double t = k / 60.0;
    const View a = flight_view(t);
    const View b = flight_view(t + step);
    const auto before = heights(*engine, a);
    const auto after = heights(*engine, b);
    const double moved = glm::length(a.eye - b.eye);
    for (const auto& [post, z] : before) {
      const auto it = after.find(post);
      if (it == after.end()) continue;
      const glm::dvec2 plan =
          terrain_.dem().georef().world_from_post.apply(post.first, post.second);
      const double distance = glm::length(b.eye - glm::dvec3(plan, z));
      // 6 tau |dP| / D with D the distance to the nearest ground, generously the height above it
      const double allowed = 6 * (moved / 100 + 0.002);
      const double px = pixel_scale(b, ErrorScale::Upright) * std::abs(it->second - z) / distance;
      worst = std::max(worst, px / allowed);
    }
  }
  EXPECT_LE(worst, 1);
  EXPECT_GT(worst, 0);
}

// The same surface whichever way a cap is come to: from every post down, or from 1 px.
TEST_F(Geomipmap, FullUnderABudgetIsThisMethod) {
  const auto exact = find_engine("full").open(*opened_, {{"patch", "17"}});
  const auto engine = geomipmap::open(*opened_, {{"patch", "17"}});
  DrawList a;
  DrawList b;
  int compared = 0;
  for (int k = 0; k < 40; ++k) {
    for (const std::uint64_t triangles : {1000, 3000, 9000}) {
      const RefineOptions options{.budget = {.triangles = triangles}};
      exact->refine(flight_view(k / 40.0), options, a);
      engine->refine(flight_view(k / 40.0), options, b);
      if (!(b.stats.tolerance_px > 1) || std::isinf(b.stats.tolerance_px)) continue;
      ++compared;
      EXPECT_NEAR(a.stats.tolerance_px / b.stats.tolerance_px, 1, 3e-3);
    }
  }
  EXPECT_GT(compared, 20);
}

TEST_F(Geomipmap, InsideABoxAFrameStillNamesItsTolerance) {
  const auto engine = geomipmap::open(*opened_, {{"patch", "17"}});
  const auto ground = [&](Post post) { return double{terrain_.dem()[post]}; };
  DrawList list;
  int capped = 0;
  for (int k = 0; k < 24; ++k) {
    const Post post{20 + 9 * k, 20 + 6 * k};
    if (!terrain_.dem().valid(post)) continue;
    const glm::dvec2 plan = terrain_.dem().georef().world_from_post.apply(post.col, post.row);
    const View view = make_view({.eye = {plan, ground(post) + 20}, .yaw = 0.3 * k}, 320, 240);
    RefineOptions options;
    engine->refine(view, options, list);
    options.budget.triangles =
        std::max(list.stats.triangles * 95 / 100, engine->footprint().least.triangles);
    engine->refine(view, options, list);
    if (list.stats.triangles > options.budget.triangles) ADD_FAILURE();
    EXPECT_GE(list.stats.tolerance_px, options.tolerance_px);
    EXPECT_LE(list.stats.achieved_error_px, list.stats.tolerance_px * (1 + 1e-4));
    capped += list.stats.tolerance_px > 1 ? 1 : 0;
  }
  EXPECT_GT(capped, 3);
}

TEST_F(Geomipmap, RefusesUnknownOptions) {
  EXPECT_THROW(geomipmap::open(*opened_, {{"pach", "17"}}), Error);
  EXPECT_THROW(geomipmap::open(*opened_, {{"patch", "18"}}), Error);
  EXPECT_THROW(geomipmap::open(*opened_, {{"patch", "33"}}), Error);  // not built
  EXPECT_THROW(find_engine("nothing"), Error);
}

TEST_F(Geomipmap, StripsDrawTheSameTriangles) {
  const auto lists = geomipmap::open(*opened_, {{"patch", "17"}});
  const auto strips = geomipmap::open(*opened_, {{"patch", "17"}, {"topology", "strip"}});
  DrawList a;
  DrawList b;
  mesh::Surface sa;
  mesh::Surface sb;
  lists->refine(flight_view(0.4), {}, a);
  strips->refine(flight_view(0.4), {}, b);
  mesh::flatten(a, *lists, sa);
  mesh::flatten(b, *strips, sb);
  EXPECT_EQ(sa.indices.size(), sb.indices.size());
  EXPECT_EQ(a.stats.triangles, b.stats.triangles);
  const auto report = mesh::check_surface(sb, terrain_.dem(), nullptr);
  EXPECT_EQ(report.flipped + report.overlaps + report.t_junctions + report.height_mismatches, 0U);
}

}  // namespace
}  // namespace arete::lod
