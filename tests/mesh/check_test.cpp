#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "arete/mesh/surface.h"

#include "mesh/toy_surface.h"

namespace arete::mesh {
namespace {

using toy::Triangle;

void expect_conforming(const SurfaceReport& r) {
  EXPECT_EQ(r.flipped, 0U);
  EXPECT_EQ(r.overlaps, 0U);
  EXPECT_EQ(r.t_junctions, 0U);
  EXPECT_EQ(r.height_mismatches, 0U);
  EXPECT_EQ(r.uncovered_cells, 0U);
}

SurfaceReport check(const std::vector<Triangle>& triangles, const Heightfield& dem,
                    const View* view = nullptr) {
  return check_surface(toy::surface_of(triangles, dem), dem, view, 2);
}

View from_above(const Heightfield& dem, double height) {
  return make_view({.eye = {dem.cols() / 2.0, -dem.rows() / 2.0, height}, .pitch = -1.5}, 640, 480);
}

TEST(CheckSurface, EveryCellIsConforming) {
  const Heightfield dem = toy::hills(23, 17);
  const SurfaceReport r = check(toy::all_cells(23, 17), dem);
  expect_conforming(r);
  EXPECT_EQ(r.triangles, 22U * 16U * 2U);
  EXPECT_EQ(r.cracks(), 0U);
}

TEST(CheckSurface, RandomRtinIsConforming) {
  for (std::uint32_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    const Heightfield dem = toy::hills(65, 65, seed);
    expect_conforming(check(toy::RandomRtin(64, seed).triangles(), dem));
  }
}

TEST(CheckSurface, PaddingBeyondTheGridMayBeDrawn) {
  const Heightfield dem = toy::hills(20, 13);
  expect_conforming(check(toy::RandomRtin(32, 5).triangles(), dem));
}

TEST(CheckSurface, EdgesOfAnySlopeAreConforming) {
  const Heightfield dem = toy::hills(8, 6);
  const Post hub{3, 2};
  const std::vector<Post> ring{{0, 0}, {0, 4}, {0, 5}, {6, 5}, {7, 5}, {7, 3}, {7, 0}, {2, 0}};
  std::vector<Triangle> fan;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    fan.push_back({hub, ring[i], ring[(i + 1) % ring.size()]});
  }
  expect_conforming(check(fan, dem));
}

TEST(CheckSurface, EachMissingTriangleIsAHole) {
  const std::vector<Triangle> whole = toy::RandomRtin(16, 3).triangles();
  const Heightfield dem = toy::hills(17, 17);
  for (std::size_t t = 0; t < whole.size(); ++t) {
    SCOPED_TRACE(t);
    std::vector<Triangle> holed = whole;
    holed.erase(holed.begin() + static_cast<std::ptrdiff_t>(t));
    const SurfaceReport r = check(holed, dem);
    EXPECT_GE(r.uncovered_cells, 1U);
    EXPECT_EQ(r.t_junctions + r.flipped + r.overlaps, 0U);
  }
}

TEST(CheckSurface, CountsHalfCellsAndCellsCutByAnySlope) {
  const Heightfield dem = toy::hills(5, 3);
  // Everything south of the line from (0,0) to (4,2): it cuts cells (0,0) (1,0) (2,1) (3,1).
  const SurfaceReport r = check({{Post{0, 0}, Post{0, 2}, Post{4, 2}}}, dem);
  EXPECT_EQ(r.uncovered_cells, 6U);
  EXPECT_EQ(r.overlaps, 0U);
}

// Fans around a random post of each square of 4 x 4 cells: edges of many slopes, conforming.
std::vector<Triangle> random_fans(int squares, std::mt19937& random) {
  std::uniform_int_distribution<int> inside(1, 3);
  std::vector<Triangle> out;
  for (int s = 0; s < squares * squares; ++s) {
    const Post nw{s % squares * 4, s / squares * 4};
    const Post hub{nw.col + inside(random), nw.row + inside(random)};
    std::vector<Post> ring;  // counter-clockwise seen from above: down the west side first
    for (int i = 0; i < 4; ++i) ring.push_back({nw.col, nw.row + i});
    for (int i = 0; i < 4; ++i) ring.push_back({nw.col + i, nw.row + 4});
    for (int i = 0; i < 4; ++i) ring.push_back({nw.col + 4, nw.row + 4 - i});
    for (int i = 0; i < 4; ++i) ring.push_back({nw.col + 4 - i, nw.row});
    for (std::size_t i = 0; i < ring.size(); ++i) {
      out.push_back({hub, ring[i], ring[(i + 1) % ring.size()]});
    }
  }
  return out;
}

// Area of a triangle within a cell, by clipping.
double area_in_cell(const Triangle& t, Post cell) {
  std::vector<glm::dvec2> polygon;
  for (const Post p : t) polygon.emplace_back(p.col - cell.col, p.row - cell.row);
  for (const glm::dvec3 half : {glm::dvec3{1, 0, 0}, {-1, 0, 1}, {0, 1, 0}, {0, -1, 1}}) {
    const auto side = [&](glm::dvec2 p) { return half.x * p.x + half.y * p.y + half.z; };
    std::vector<glm::dvec2> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const glm::dvec2 a = polygon[i];
      const glm::dvec2 b = polygon[(i + 1) % polygon.size()];
      if (side(a) >= 0) kept.push_back(a);
      if ((side(a) >= 0) != (side(b) >= 0))
        kept.push_back(a + (b - a) * (side(a) / (side(a) - side(b))));
    }
    polygon = kept;
  }
  double doubled = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec2 a = polygon[i];
    const glm::dvec2 b = polygon[(i + 1) % polygon.size()];
    doubled += a.x * b.y - a.y * b.x;
  }
  return std::abs(doubled) / 2;
}

TEST(CheckSurface, CoverageEqualsClippedAreas) {
  constexpr int kSquares = 3;
  constexpr int kPosts = 4 * kSquares + 1;
  const Heightfield dem = toy::hills(kPosts, kPosts);
  std::mt19937 random(11);
  for (int trial = 0; trial < 60; ++trial) {
    SCOPED_TRACE(trial);
    std::vector<Triangle> triangles = random_fans(kSquares, random);
    expect_conforming(check(triangles, dem));
    std::shuffle(triangles.begin(), triangles.end(), random);
    // A few triangles are missing and, on odd trials, a few are drawn twice.
    const bool twice = trial % 2 != 0;
    if (twice) std::copy_n(triangles.begin(), 3, triangles.end() - 3);
    if (!twice) triangles.resize(triangles.size() - 5);
    std::uint64_t uncovered = 0;
    bool overlapped = false;
    for (int r = 0; r + 1 < kPosts; ++r) {
      for (int c = 0; c + 1 < kPosts; ++c) {
        double area = 0;
        for (const Triangle& t : triangles) area += area_in_cell(t, {c, r});
        uncovered += static_cast<std::uint64_t>(area < 1 - 1e-9);
        overlapped = overlapped || area > 1 + 1e-9;
      }
    }
    const SurfaceReport r = check(triangles, dem);
    if (!twice) {
      EXPECT_EQ(r.uncovered_cells, uncovered);
    }
    EXPECT_EQ(r.overlaps > 0, overlapped || twice);
    EXPECT_GT(r.cracks(), 0U);
  }
}

TEST(CheckSurface, HolesWithoutDataNeedNoCover) {
  Heightfield dem = toy::hills(9, 9);
  dem[{4, 4}] = std::nanf("");
  std::vector<Triangle> triangles;
  for (const Triangle& t : toy::all_cells(9, 9)) {
    if (t[0] != Post{4, 4} && t[1] != Post{4, 4} && t[2] != Post{4, 4}) triangles.push_back(t);
  }
  EXPECT_EQ(check(triangles, dem).uncovered_cells, 0U);
  dem[{4, 4}] = 0;
  EXPECT_EQ(check(triangles, dem).uncovered_cells, 4U);
}

TEST(CheckSurface, CatchesATJunction) {
  const Heightfield dem = toy::hills(3, 3);
  const std::vector<Triangle> triangles{{Post{0, 0}, Post{0, 2}, Post{2, 2}},
                                        {Post{0, 0}, Post{1, 1}, Post{2, 0}},
                                        {Post{1, 1}, Post{2, 2}, Post{2, 0}}};
  const SurfaceReport r = check(triangles, dem);
  EXPECT_EQ(r.t_junctions, 2U);
  EXPECT_EQ(r.cracks(), 0U);
}

TEST(CheckSurface, CatchesATJunctionHiddenByATriangleWithoutArea) {
  const Heightfield dem = toy::hills(3, 3);
  const std::vector<Triangle> triangles{{Post{0, 0}, Post{0, 2}, Post{2, 2}},
                                        {Post{0, 0}, Post{2, 2}, Post{1, 1}},
                                        {Post{0, 0}, Post{1, 1}, Post{2, 0}},
                                        {Post{1, 1}, Post{2, 2}, Post{2, 0}}};
  const SurfaceReport r = check(triangles, dem);
  EXPECT_EQ(r.flipped, 1U);
  EXPECT_EQ(r.t_junctions, 2U);
}

TEST(CheckSurface, CatchesAHeightOneBitOff) {
  const Heightfield dem = toy::hills(9, 9);
  Surface s = toy::surface_of(toy::all_cells(9, 9), dem);
  s.vertices.push_back(s.vertices[20]);  // as another batch would
  s.indices[static_cast<std::size_t>(std::ranges::find(s.indices, 20U) - s.indices.begin())] =
      static_cast<std::uint32_t>(s.vertices.size() - 1);
  EXPECT_EQ(check_surface(s, dem, nullptr).cracks(), 0U);
  s.vertices.back().z = std::nextafter(s.vertices.back().z, 1e9F);
  EXPECT_EQ(check_surface(s, dem, nullptr).height_mismatches, 1U);
}

TEST(CheckSurface, CatchesAHeightThatIsNotANumber) {
  const Heightfield dem = toy::hills(3, 3);
  Surface s = toy::surface_of(toy::all_cells(3, 3), dem);
  s.vertices[0].z = std::nanf("");
  EXPECT_EQ(check_surface(s, dem, nullptr).height_mismatches, 1U);
}

TEST(CheckSurface, CatchesAFlippedTriangle) {
  const Heightfield dem = toy::hills(9, 9);
  std::vector<Triangle> triangles = toy::all_cells(9, 9);
  std::swap(triangles[17][0], triangles[17][1]);
  const SurfaceReport r = check(triangles, dem);
  EXPECT_EQ(r.flipped, 1U);
  EXPECT_GE(r.overlaps, 1U);
}

TEST(CheckSurface, CatchesTheSameTriangleTwice) {
  const Heightfield dem = toy::hills(9, 9);
  std::vector<Triangle> triangles = toy::all_cells(9, 9);
  triangles.push_back(triangles[40]);
  EXPECT_GE(check(triangles, dem).overlaps, 3U);
}

TEST(CheckSurface, CatchesAParentDrawnOverItsChildren) {
  const Heightfield dem = toy::hills(9, 9);
  std::vector<Triangle> triangles = toy::all_cells(9, 9);
  triangles.push_back({Post{2, 2}, Post{2, 6}, Post{6, 6}});
  triangles.push_back({Post{2, 2}, Post{6, 6}, Post{6, 2}});
  EXPECT_GE(check(triangles, dem).overlaps, 16U);
}

TEST(CheckSurface, WithAViewOnlyWhatItSeesMustBeCovered) {
  const Heightfield dem = toy::hills(65, 65);
  const View view = from_above(dem, 20);
  std::vector<Triangle> middle;
  std::vector<Triangle> holed;
  for (const Triangle& t : toy::all_cells(65, 65)) {
    const int away = std::max(std::abs(t[0].col - 32), std::abs(t[0].row - 32));
    if (away < 30) middle.push_back(t);
    if (away < 30 && away > 2) holed.push_back(t);
  }
  EXPECT_EQ(check(middle, dem, &view).cracks(), 0U);
  EXPECT_GT(check(middle, dem).uncovered_cells, 100U);
  EXPECT_GT(check(holed, dem, &view).uncovered_cells, 8U);
  EXPECT_LT(check(holed, dem, &view).uncovered_cells, 64U);
}

TEST(CheckSurface, NothingDrawnIsNothingCovered) {
  const Heightfield dem = toy::hills(9, 7);
  EXPECT_EQ(check({}, dem).uncovered_cells, 48U);
  EXPECT_EQ(check({}, Heightfield(1, 9)).cracks(), 0U);
}

}  // namespace
}  // namespace arete::mesh
