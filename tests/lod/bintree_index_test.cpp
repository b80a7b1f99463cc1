#include <cmath>
#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/lod/bintree/record.h"
#include "arete/lod/bintree/vertex_index.h"

namespace arete::lod::bintree {
namespace {

struct Corner {
  VertexIndex index;
  Post post;
};

Post middle(Post a, Post b) {
  return {(a.col + b.col) / 2, (a.row + b.row) / 2};
}

// Twice the area, positive when a, b, c turn counter-clockwise seen from above (rows run south).
long long turn(Post a, Post b, Post c) {
  return static_cast<long long>(c.col - a.col) * (b.row - a.row) -
         static_cast<long long>(b.col - a.col) * (c.row - a.row);
}

// Bisects every triangle down to the finest depth and calls visit(index, place, depth).
template <typename Visit>
void bisect(Corner apex, Corner left, Corner right, VertexIndex middle_index, int depth, int depths,
            const Visit& visit) {
  const Corner m{middle_index, middle(left.post, right.post)};
  EXPECT_EQ(turn(apex.post, left.post, right.post) > 0, depth % 2 == 1);
  visit(m, depth);
  if (depth + 1 == depths) return;
  bisect(m, left, apex, left_child(apex.index, m.index), depth + 1, depths, visit);
  bisect(m, apex, right, right_child(apex.index, m.index), depth + 1, depths, visit);
}

template <typename Visit>
void bisect_all(const Domain& domain, const Visit& visit) {
  const auto at = [&](VertexIndex index) { return Corner{index, domain.post_of(index)}; };
  for (const RootTriangle& root : kRootTriangles)
    bisect(at(kCentre), at(root.left), at(root.right), root.middle, 1, domain.depths(), visit);
}

TEST(BintreeIndex, RefinementMeetsEveryPostUnderItsNumber) {
  for (int k = 1; k <= 7; ++k) {
    SCOPED_TRACE(k);
    const Domain domain(k);
    std::set<VertexIndex> met{kCentre, kSouthWest, kSouthEast, kNorthEast, kNorthWest};
    bisect_all(domain, [&](const Corner& m, int depth) {
      met.insert(m.index);
      ASSERT_EQ(domain.index_of(m.post), m.index);
      ASSERT_EQ(domain.post_of(m.index), m.post);
      ASSERT_EQ(Domain::depth_of(m.index), depth);
    });
    const auto posts = static_cast<std::size_t>(domain.side() + 1);
    EXPECT_EQ(met.size(), posts * posts);
    EXPECT_LT(*met.rbegin(), domain.index_end());
  }
}

TEST(BintreeIndex, PostsAndNumbersAreOneToOne) {
  for (int k = 1; k <= 8; ++k) {
    SCOPED_TRACE(k);
    const Domain domain(k);
    std::uint64_t inside = 0;
    std::uint64_t vertices = 0;
    for (VertexIndex i = 0; i < domain.index_end(); ++i) {
      if (!domain.is_vertex(i)) continue;
      ++vertices;
      const Post post = domain.post_of(i);
      if (post.col < 0 || post.row < 0 || post.col > domain.side() || post.row > domain.side())
        continue;
      ++inside;
      ASSERT_EQ(domain.index_of(post), i);
    }
    // As many as the packed form has [LindstromPascucci2002]: 4 + 5 (4^k - 1) / 3.
    EXPECT_EQ(vertices, 4 + 5 * ((std::uint64_t{1} << (2 * k)) - 1) / 3);
    EXPECT_EQ(inside, static_cast<std::uint64_t>(domain.side() + 1) *
                          static_cast<std::uint64_t>(domain.side() + 1));
  }
}

TEST(BintreeIndex, TheLargestDomainKeepsItsNumbers) {
  const Domain domain(Domain::kMaxLog2Cells);
  for (const Post post : {Post{0, 0}, Post{1, 1}, Post{1, 0}, Post{0, 1}, Post{1 << 20, 1},
                          Post{(1 << 20) - 1, (1 << 20) - 1}, Post{123456, 654321}}) {
    EXPECT_EQ(domain.post_of(domain.index_of(post)), post);
    EXPECT_LT(domain.index_of(post), domain.index_end());
  }
}

TEST(BintreeIndex, TheDomainIsTheSmallestSquare) {
  EXPECT_EQ(Domain::over(1, 1).side(), 2);
  EXPECT_EQ(Domain::over(3, 2).side(), 2);
  EXPECT_EQ(Domain::over(4, 1).side(), 4);
  EXPECT_EQ(Domain::over(1025, 7).side(), 1024);
  EXPECT_EQ(Domain::over(1, 1026).side(), 2048);
  EXPECT_EQ(Domain::over((1 << 20) + 1, 1).log2_cells(), 20);
  EXPECT_THROW(Domain::over((1 << 20) + 2, 1), Error);
  EXPECT_TRUE(Domain::fits(1, (1 << 20) + 1) && !Domain::fits(1, (1 << 20) + 2));
}

TEST(BintreeRecord, CodesRoundUpByLittleAndKeepOrder) {
  EXPECT_EQ(code_up(0), 0);
  EXPECT_EQ(value(code_up(1)), 1.0F);
  EXPECT_EQ(code_up(std::numeric_limits<double>::infinity()), kInfinite);
  EXPECT_TRUE(std::isinf(value(kInfinite)));
  Code last = 0;
  for (double x = 1e-6; x < 1e7; x *= 1.0037) {
    const Code code = code_up(x);
    ASSERT_GE(value(code), x);
    ASSERT_LE(value(code), x * (1 + 0x1p-8));
    ASSERT_LT(value(static_cast<Code>(code - 1)), x);
    ASSERT_GE(code, last);
    last = code;
  }
}

}  // namespace
}  // namespace arete::lod::bintree
