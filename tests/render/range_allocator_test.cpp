#include "arete/render/range_allocator.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace arete::render {
namespace {

struct Range {
  std::uint64_t first, count;
};

// True when no two ranges share a unit and none leaves [0, size).
bool disjoint(const std::vector<Range>& ranges, std::uint64_t size) {
  std::vector<bool> used(size, false);
  for (const Range& r : ranges) {
    for (std::uint64_t i = r.first; i < r.first + r.count; ++i) {
      if (i >= size || used[i]) return false;
      used[i] = true;
    }
  }
  return true;
}

TEST(RangeAllocator, CheckerFindsAnOverlap) {
  EXPECT_TRUE(disjoint({{0, 4}, {4, 4}}, 8));
  EXPECT_FALSE(disjoint({{0, 4}, {3, 2}}, 8));
  EXPECT_FALSE(disjoint({{6, 4}}, 8));
}

TEST(RangeAllocator, RangesStayDisjointAndAllComesBack) {
  std::mt19937_64 random(1);
  RangeAllocator allocator(200);
  std::vector<Range> taken;
  for (int step = 0; step < 4000; ++step) {
    const std::uint64_t count = 1 + random() % 40;
    const bool take = taken.empty() || random() % 2 == 0;
    if (take) {
      const auto first = random() % 3 == 0 ? allocator.take_last(count) : allocator.take(count);
      if (first) taken.push_back({*first, count});
    } else {
      const std::size_t i = random() % taken.size();
      allocator.give(taken[i].first, taken[i].count);
      taken[i] = taken.back();
      taken.pop_back();
    }
    if (step == 2000) allocator.grow(300);
    ASSERT_TRUE(disjoint(taken, allocator.size()));
  }
  for (const Range& r : taken) allocator.give(r.first, r.count);
  EXPECT_EQ(allocator.taken(), 0U);
  EXPECT_EQ(allocator.take(300), 0U);
}

TEST(RangeAllocator, RefusesWhatDoesNotFit) {
  RangeAllocator allocator(8);
  EXPECT_EQ(allocator.take(5), 0U);
  EXPECT_FALSE(allocator.take(4).has_value());
  EXPECT_EQ(allocator.take_last(2), 6U);
}

}  // namespace
}  // namespace arete::render
