#include "arete/lod/rtin.h"

#include <algorithm>
#include <bit>
#include <map>
#include <set>

#include <gtest/gtest.h>

namespace arete::lod {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

// Twice the area, counter-clockwise seen from above positive (rows run south).
int area(const RtinSquare& s, const Triangle& t) {
  const auto n = static_cast<std::uint32_t>(s.posts());
  const auto i = [n](std::uint32_t v) { return static_cast<int>(v % n); };
  const auto j = [n](std::uint32_t v) { return -static_cast<int>(v / n); };
  return (i(t[1]) - i(t[0])) * (j(t[2]) - j(t[0])) - (j(t[1]) - j(t[0])) * (i(t[2]) - i(t[0]));
}

std::vector<Triangle> triangles(std::span<const std::uint32_t> list) {
  std::vector<Triangle> out;
  for (std::size_t k = 0; k < list.size(); k += 3)
    out.push_back({list[k], list[k + 1], list[k + 2]});
  return out;
}

std::set<Triangle> canonical(const std::vector<Triangle>& list) {
  std::set<Triangle> out;
  for (Triangle t : list) {
    std::ranges::rotate(t, std::ranges::min_element(t));
    out.insert(t);
  }
  return out;
}

TEST(Rtin, CountsAreThePapers) {  // [Wagner2003]: 512, 128, 32, 8, 2
  for (const auto& [cells, count] :
       std::map<int, std::size_t>{{16, 512}, {8, 128}, {4, 32}, {2, 8}, {1, 2}}) {
    EXPECT_EQ(rtin_triangles({cells, false}, 0).size() / 3, count);
  }
}

TEST(Rtin, EachAdaptedSideSavesHalfItsCells) {
  for (const int cells : {2, 4, 8, 16}) {
    for (unsigned mask = 0; mask < 16; ++mask) {
      const auto expected = 2 * cells * cells - std::popcount(mask) * cells / 2;
      EXPECT_EQ(rtin_triangles({cells, false}, mask).size() / 3,
                static_cast<std::size_t>(expected));
    }
  }
}

TEST(Rtin, CoversTheSquareOnceCounterClockwise) {
  for (const int cells : {1, 2, 4, 8}) {
    for (unsigned mask = 0; mask < (cells == 1 ? 1U : 16U); ++mask) {
      for (const bool odd : {false, true}) {
        const RtinSquare square{cells, odd};
        int sum = 0;
        std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
        for (const Triangle& t : triangles(rtin_triangles(square, mask))) {
          EXPECT_GT(area(square, t), 0);
          sum += area(square, t);
          for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
        }
        EXPECT_EQ(sum, 2 * cells * cells);
        std::size_t border = 0;
        for (const auto& [edge, uses] : edges) {
          EXPECT_EQ(uses, 1);
          if (!edges.contains({edge.second, edge.first})) ++border;
        }
        EXPECT_EQ(border, static_cast<std::size_t>(4 * cells - std::popcount(mask) * cells / 2));
      }
    }
  }
}

TEST(Rtin, ParentsAreTheEndsOfACoarserEdge) {
  for (const int cells : {2, 4, 8}) {
    for (const bool odd : {false, true}) {
      const RtinSquare coarse{cells / 2, odd};
      std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
      for (const Triangle& t : triangles(rtin_triangles(coarse, 0))) {
        for (std::size_t k = 0; k < 3; ++k) edges.insert({t[k], t[(k + 1) % 3]});
      }
      for (int j = 0; j <= cells; ++j) {
        for (int i = 0; i <= cells; ++i) {
          if (i % 2 == 0 && j % 2 == 0) continue;
          const auto [p, q] = morph_parents({cells, odd}, i, j);
          EXPECT_EQ(p.first + q.first, 2 * i);
          EXPECT_EQ(p.second + q.second, 2 * j);
          const auto a = local_vertex(coarse, p.first / 2, p.second / 2);
          const auto b = local_vertex(coarse, q.first / 2, q.second / 2);
          EXPECT_TRUE(edges.contains({a, b}) || edges.contains({b, a}))
              << cells << ' ' << i << ' ' << j;
        }
      }
    }
  }
}

TEST(Rtin, StripHoldsTheSameTriangles) {
  for (const int cells : {1, 2, 4, 16}) {
    for (unsigned mask = 0; mask < (cells == 1 ? 1U : 16U); ++mask) {
      const auto list = rtin_triangles({cells, true}, mask);
      const auto strip = as_strip(list);
      std::vector<Triangle> drawn;
      for (std::size_t k = 0; k + 2 < strip.size(); ++k) {
        Triangle t{strip[k], strip[k + 1], strip[k + 2]};
        if (k % 2 != 0) std::swap(t[0], t[1]);
        if (t[0] != t[1] && t[1] != t[2] && t[0] != t[2]) drawn.push_back(t);
      }
      EXPECT_EQ(drawn.size(), list.size() / 3);
      EXPECT_EQ(canonical(drawn), canonical(triangles(list)));
      EXPECT_LE(strip.size(), list.size());  // what PatchBlocks counts on
    }
  }
}

}  // namespace
}  // namespace arete::lod
