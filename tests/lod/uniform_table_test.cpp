#include "arete/lod/uniform_table.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "lod/built_terrain.h"

namespace arete::lod {
namespace {

// Height of the mesh with uniform diagonals of spacing s at a post, from the stored posts.
double mesh_height(const Heightfield& dem, Post first, int s, Post p) {
  const auto h = [&](int col, int row) -> double {
    return dem[{std::min(col, dem.cols() - 1), std::min(row, dem.rows() - 1)}];
  };
  const int c0 = first.col + (p.col - first.col) / s * s;
  const int r0 = first.row + (p.row - first.row) / s * s;
  const double x = static_cast<double>(p.col - c0) / s;
  const double y = static_cast<double>(p.row - r0) / s;
  if (x == 0 && y == 0) return h(p.col, p.row);
  const double far = h(c0 + s, r0 + s);
  if (x >= y) return h(c0, r0) + x * (h(c0 + s, r0) - h(c0, r0)) + y * (far - h(c0 + s, r0));
  return h(c0, r0) + y * (h(c0, r0 + s) - h(c0, r0)) + x * (far - h(c0, r0 + s));
}

TEST(UniformTable, IsTheFurthestPostOfEachLevel) {
  const BuiltTerrain built(rough_dem(129, 97, 3, 0), {{"patch", "17"}});
  const auto terrain = built.open();
  const PatchTable patches(*terrain, 4);
  const UniformTable table(*terrain, patches);
  for (int p = 0; p < patches.size(); ++p) {
    const Post first{16 * patches.x(p), 16 * patches.y(p)};
    for (int level = 1; level <= 4; ++level) {
      double worst = 0;
      for (int row = first.row; row <= first.row + 16; ++row) {
        for (int col = first.col; col <= first.col + 16; ++col) {
          worst = std::max(worst, std::abs(mesh_height(built.dem(), first, 1 << level, {col, row}) -
                                           double{built.dem()[{col, row}]}));
        }
      }
      const MaxErrorVertex& v = table.at(p, level);
      SCOPED_TRACE(fmt::format("patch {} level {}", p, level));
      EXPECT_NEAR(std::abs(double{v.drawn_z} - double{v.z}), worst, 1e-3);
      EXPECT_NEAR(v.z, (built.dem()[v.post]), 1e-3);
      EXPECT_NEAR(v.drawn_z, mesh_height(built.dem(), first, 1 << level, v.post), 1e-3);
      EXPECT_GE(v.bound * (1 + 1e-6), worst);
      EXPECT_GE(v.bound, table.bound(p, level - 1));  // never falls
    }
  }
}

TEST(UniformTable, PicksPostsOfDrawableCellsButBoundsAll) {
  Heightfield dem = rough_dem(65, 65, 3, 0);
  for (int col = 0; col < 65; ++col) {
    for (int row = 20; row < 40; ++row) dem[{col, row}] = std::numeric_limits<float>::quiet_NaN();
  }
  const BuiltTerrain built(std::move(dem), {{"patch", "17"}});
  const auto terrain = built.open();
  const PatchTable patches(*terrain, 4);
  const UniformTable table(*terrain, patches);
  for (int p = 0; p < patches.size(); ++p) {
    if (!patches.drawable(p)) continue;
    for (int level = 1; level <= 4; ++level) {
      const MaxErrorVertex& v = table.at(p, level);
      if (v.z != v.drawn_z) {
        EXPECT_TRUE(built.dem().valid(v.post));
      }
      EXPECT_GE(v.bound * (1 + 1e-6F) + 1e-4F, std::abs(v.z - v.drawn_z));
    }
  }
}

}  // namespace
}  // namespace arete::lod
