#include "arete/lod/uniform_mesh.h"

#include <bit>
#include <map>
#include <random>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "lod/uniform_patch.h"

namespace arete::lod {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

std::vector<Triangle> triangles_of(std::span<const std::uint32_t> list) {
  std::vector<Triangle> out;
  for (std::size_t k = 0; k < list.size(); k += 3)
    out.push_back({list[k], list[k + 1], list[k + 2]});
  return out;
}

Triangle turned(Triangle t) {
  std::ranges::rotate(t, std::ranges::min_element(t));
  return t;
}

// Twice the area, counter-clockwise seen from above positive (rows run south).
int area(int cells, const Triangle& t) {
  const auto n = static_cast<std::uint32_t>(cells + 1);
  const auto i = [n](std::uint32_t v) { return static_cast<int>(v % n); };
  const auto j = [n](std::uint32_t v) { return -static_cast<int>(v / n); };
  return (i(t[1]) - i(t[0])) * (j(t[2]) - j(t[0])) - (j(t[1]) - j(t[0])) * (i(t[2]) - i(t[0]));
}

using Edge = std::pair<std::uint32_t, std::uint32_t>;

// The posts that a side keeps, as edges of the boundary, counter-clockwise.
std::set<Edge> boundary(int cells, const SideDrops& drops) {
  std::set<Edge> out;
  const auto v = [cells](int i, int j) { return local_vertex({cells}, i, j); };
  for (const Side q : kAllSides) {
    const int step = 1 << drops[static_cast<std::size_t>(q)];
    for (int a = 0; a < cells; a += step) {
      if (q == West) out.insert({v(0, a), v(0, a + step)});
      if (q == North) out.insert({v(a + step, 0), v(a, 0)});
      if (q == East) out.insert({v(cells, a + step), v(cells, a)});
      if (q == South) out.insert({v(a, cells), v(a + step, cells)});
    }
  }
  return out;
}

// "" when the list covers the square once, counter-clockwise, and its boundary is as it should be.
std::string fault(int cells, const SideDrops& drops, const std::vector<Triangle>& list) {
  int sum = 0;
  std::set<Edge> edges;
  for (const Triangle& t : list) {
    if (area(cells, t) <= 0) return "a triangle is flipped or empty";
    sum += area(cells, t);
    for (std::size_t k = 0; k < 3; ++k) {
      if (!edges.insert({t[k], t[(k + 1) % 3]}).second) return "an edge is used twice";
    }
  }
  if (sum != 2 * cells * cells) return "the area is wrong";
  std::set<Edge> border;
  for (const Edge& e : edges) {
    if (!edges.contains({e.second, e.first})) border.insert(e);
  }
  return border == boundary(cells, drops) ? "" : "the boundary is wrong";
}

std::vector<SideDrops> all_drops(int cells) {
  const int most = std::countr_zero(static_cast<unsigned>(cells));
  std::vector<SideDrops> out;
  SideDrops d{};
  while (true) {
    out.push_back(d);
    std::size_t k = 0;
    while (k < kSides && d[k] == most) d[k++] = 0;
    if (k == kSides) return out;
    ++d[k];
  }
}

TEST(UniformMesh, CountsAreThePapers) {  // [Wagner2003]: 512, 128, 32, 8, 2
  for (const auto& [cells, count] :
       std::map<int, std::size_t>{{16, 512}, {8, 128}, {4, 32}, {2, 8}, {1, 2}}) {
    EXPECT_EQ(uniform_triangles(cells, {}).size() / 3, count);
  }
}

TEST(UniformMesh, AnyDropsCoverTheSquareOnceAndKeepTheirPosts) {
  for (const int cells : {1, 2, 4, 8, 16}) {
    for (const SideDrops& drops : all_drops(cells)) {
      const auto list = uniform_triangles(cells, drops);
      ASSERT_EQ(fault(cells, drops, triangles_of(list)), "")
          << cells << ' ' << fmt::format("{}", drops);
      ASSERT_EQ(list.size() / 3, uniform_triangle_count(cells, drops));
    }
  }
}

TEST(UniformMesh, TheCheckSeesPlantedFaults) {
  const SideDrops drops{2, 0, 1, 3};
  const auto good = triangles_of(uniform_triangles(8, drops));
  auto lost = good;
  lost.pop_back();
  EXPECT_NE(fault(8, drops, lost), "");
  auto flipped = good;
  std::swap(flipped[5][0], flipped[5][1]);
  EXPECT_NE(fault(8, drops, flipped), "");
  EXPECT_NE(fault(8, {2, 0, 1, 2}, good), "");  // the neighbour stands elsewhere: a T-junction
}

TEST(UniformMesh, DiagonalsAreUniformAwayFromAdaptedSides) {
  const auto falls = [](const Triangle& t, int cells) {
    std::set<Edge> edges;
    for (std::size_t k = 0; k < 3; ++k)
      edges.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    return std::ranges::any_of(edges, [&](const Edge& e) {
      return e.second - e.first == static_cast<std::uint32_t>(cells) + 2;
    });
  };
  for (const Triangle& t : triangles_of(uniform_triangles(8, {}))) EXPECT_TRUE(falls(t, 8));
}

TEST(UniformMesh, StripHoldsTheSameTriangles) {
  for (const int cells : {1, 2, 4, 8}) {
    for (const SideDrops& drops : all_drops(cells)) {
      const auto list = uniform_triangles(cells, drops);
      const auto strip = uniform_strip(cells, drops);
      std::set<Triangle> drawn;
      for (std::size_t k = 0; k + 2 < strip.size(); ++k) {
        Triangle t{strip[k], strip[k + 1], strip[k + 2]};
        if (k % 2 != 0) std::swap(t[0], t[1]);
        if (t[0] == t[1] || t[1] == t[2] || t[0] == t[2]) continue;
        EXPECT_TRUE(drawn.insert(turned(t)).second);
      }
      std::set<Triangle> wanted;
      for (const Triangle& t : triangles_of(list)) wanted.insert(turned(t));
      EXPECT_EQ(drawn, wanted);
      EXPECT_LE(strip.size(), list.size());  // what PatchBlocks counts on
    }
  }
  EXPECT_LT(uniform_strip(16, {}).size(), uniform_triangles(16, {}).size() / 2);
}

Levels random_levels(std::mt19937_64& random, int w) {
  std::uniform_real_distribution<float> unit(0, 1);
  Levels levels;
  levels.own = unit(random) * static_cast<float>(w);
  for (float& side : levels.side) {
    side = std::max(levels.own, unit(random) * static_cast<float>(w));
  }
  return levels;
}

// The height of a side's post when the side stands at a real level: the line through the posts that
// it keeps, each on its own way to the line of the next level.
double side_height(const UniformPatch& p, Side q, int along) {
  const auto height = [&](int a) {
    const int n = p.patch.posts() - 1;
    if (q == West) return p.patch.height(0, a);
    if (q == North) return p.patch.height(a, 0);
    return q == East ? p.patch.height(n, a) : p.patch.height(a, n);
  };
  const auto line = [&](int level) {
    const int step = 1 << level;
    const int a = along / step * step;
    if (a == along) return height(a);
    const double share = static_cast<double>(along - a) / step;
    return (1 - share) * height(a) + share * height(a + step);
  };
  const int e = p.side_level(q);
  if (e == p.patch.w()) return line(e);
  return (1 - p.side_t(q)) * line(e) + p.side_t(q) * line(e + 1);
}

double expected_height(const UniformPatch& p, int col, int row) {
  const int n = p.patch.posts() - 1;
  if (col == 0 || col == n) return side_height(p, col == 0 ? West : East, row);
  if (row == 0 || row == n) return side_height(p, row == 0 ? North : South, col);
  const int s = 1 << p.level();
  const int di = col % (2 * s);
  const int dj = row % (2 * s);
  if (di == 0 && dj == 0) return p.patch.height(col, row);
  UniformPatch still = p;  // an inner parent stands at its own height
  still.levels.own = static_cast<float>(p.level());
  const auto parent = [&](int c, int r) {
    const bool inside = c > 0 && c < n && r > 0 && r < n;
    return inside ? p.patch.height(c, r) : expected_height(still, c, r);
  };
  const double mean = (parent(col - di, row - dj) + parent(col + di, row + dj)) / 2;
  return (1 - p.t()) * p.patch.height(col, row) + p.t() * mean;
}

TEST(UniformMesh, PrintedNineFactorsEqualTheRecursiveHeight) {
  std::mt19937_64 random(9);
  int three = 0;
  for (int k = 0; k < 400; ++k) {
    const RandomPatch patch(2 + k % 4, false, static_cast<std::uint64_t>(k), 25);
    const UniformPatch drawn{patch, random_levels(random, patch.w())};
    const auto f = drawn.factors();
    const auto vertices = drawn.vertices();
    for (const std::uint32_t i : uniform_triangles(drawn.cells(), drawn.drops())) {
      const Vertex& v = vertices[i];
      const double expected = expected_height(drawn, v.post.col, v.post.row);
      ASSERT_NEAR(morphed_z(v, f), expected, 1e-6 * std::max(1.0, std::abs(expected)) + 2e-3)
          << "case " << k << " post " << v.post.col << ',' << v.post.row;
      three += v.slot[2] != 255 ? 1 : 0;
    }
  }
  EXPECT_GT(three, 0);  // posts that follow two sides were among them
}

TEST(UniformMesh, CornersNeverMove) {
  std::mt19937_64 random(4);
  for (int k = 0; k < 50; ++k) {
    const RandomPatch patch(4, false, static_cast<std::uint64_t>(k), 40);
    const UniformPatch drawn{patch, random_levels(random, 4)};
    const auto vertices = drawn.vertices();
    const int n = drawn.cells();
    for (const auto& [i, j] : {std::pair{0, 0}, {n, 0}, {0, n}, {n, n}}) {
      for (const float d : vertices[local_vertex({n}, i, j)].dz) EXPECT_EQ(d, 0);
    }
  }
}

// "tweeningA": A lies in the middle of vertex 1, wherever the side is, and vertex 2, when it
// leaves.
TEST(UniformMesh, OwnSwitchDoesNotJumpWhileSidesDropOneLevelAtMost) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<float> unit(0, 1);
  double worst = 0;
  double with_one_delta = 0;
  for (int k = 0; k < 200; ++k) {
    const int w = 2 + k % 3;
    const RandomPatch patch(w, false, static_cast<std::uint64_t>(k), 25);
    const int l = k % w;
    Levels levels;
    const auto above = static_cast<float>(l + 1);
    for (float& side : levels.side)
      side = std::min(static_cast<float>(w), above + 0.99F * unit(random));
    levels.own = std::nextafter(above, 0.0F);
    const UniformPatch before{patch, levels};
    levels.own = above;
    const UniformPatch after{patch, levels};
    worst = std::max(worst, largest_difference(before.drawn(), after.drawn()));
    // The control: A with a single delta, as the article's formula alone would have it, does jump.
    auto vertices = before.vertices();
    for (Vertex& v : vertices) v.dz[1] = v.dz[2] = 0;
    const auto one = heights_of(vertices, uniform_triangles(before.cells(), before.drops()),
                                before.factors(), patch.posts());
    with_one_delta = std::max(with_one_delta, largest_difference(one, after.drawn()));
  }
  EXPECT_LT(worst, 1e-2);
  EXPECT_GT(with_one_delta, 1);
}

struct Spoke {
  glm::dvec2 a, b;
  double za, zb;
};

std::vector<Spoke> spokes(const UniformPatch& p) {
  const auto vertices = p.vertices();
  const auto f = p.factors();
  const auto list = uniform_triangles(p.cells(), p.drops());
  std::vector<Spoke> out;
  for (std::size_t t = 0; t < list.size(); ++t) {
    const Vertex& a = vertices[list[t]];
    const Vertex& b = vertices[list[t % 3 == 2 ? t - 2 : t + 1]];
    out.push_back(
        {{a.post.col, a.post.row}, {b.post.col, b.post.row}, morphed_z(a, f), morphed_z(b, f)});
  }
  return out;
}

// The largest height between two edges where they cross, one of each mesh: the two surfaces are
// linear between such crossings, so nowhere are they further apart.
double diagonal_residual(const UniformPatch& p, const UniformPatch& q) {
  double worst = 0;
  const auto cross = [](glm::dvec2 u, glm::dvec2 v) { return u.x * v.y - u.y * v.x; };
  const auto others = spokes(q);
  for (const Spoke& s : spokes(p)) {
    for (const Spoke& o : others) {
      const double d = cross(s.b - s.a, o.b - o.a);
      if (d == 0) continue;
      const double x = cross(o.a - s.a, o.b - o.a) / d;
      const double y = cross(o.a - s.a, s.b - s.a) / d;
      if (x < 0 || x > 1 || y < 0 || y > 1) continue;
      worst = std::max(worst, std::abs(s.za + x * (s.zb - s.za) - o.za - y * (o.zb - o.za)));
    }
  }
  return worst;
}

// METHODS 7.8(4): when a neighbour switches the band is triangulated anew and the surface jumps, by
// no more than the heights between the old and the new diagonals.
TEST(UniformMesh, NeighbourSwitchJumpsByTheBandsDiagonalsAtMost) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<float> unit(0, 1);
  double largest = 0;
  for (int k = 0; k < 60; ++k) {
    const RandomPatch patch(4, false, static_cast<std::uint64_t>(k), 25);
    Levels levels;
    levels.own = 2 * unit(random);
    const auto switched = std::ceil(levels.own + 0.01F) + static_cast<float>(k % 2);
    levels.side.fill(levels.own);
    levels.side[static_cast<std::size_t>(k % kSides)] = std::nextafter(switched, 0.0F);
    const UniformPatch before{patch, levels};
    levels.side[static_cast<std::size_t>(k % kSides)] = switched;
    const UniformPatch after{patch, levels};
    const double jump = largest_difference(before.drawn(), after.drawn());
    EXPECT_LE(jump, diagonal_residual(before, after) + 1e-2);
    largest = std::max(largest, jump);
  }
  EXPECT_GT(largest,
            1);  // it does jump; exact mode's blocks do not (PatchBlocks, Geomipmap.NothingPops)
}

}  // namespace
}  // namespace arete::lod
