// The tables that keep a frame of SMART as small as its changes, against plain searches.
#include <algorithm>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "arete/lod/bintree/code_counts.h"
#include "arete/lod/bintree/odometer.h"
#include "arete/lod/bintree/range_ends.h"
#include "arete/lod/bintree/triangle_list.h"

namespace arete::lod::bintree {
namespace {

TEST(RangeEnds, RenewsWhatASearchFinds) {
  constexpr std::uint32_t kPlaces = 3000;
  std::mt19937_64 random(7);
  const auto below = [&](int n) { return static_cast<Tick>(random() % static_cast<unsigned>(n)); };
  RangeEnds ends;
  ends.reserve(100);  // it grows by itself
  std::vector<Ticks> limits(kPlaces, {kForever, kForever, kForever});
  Ticks now{1, 1, 1};
  std::size_t renewed = 0;
  for (int frame = 0; frame < 500; ++frame) {
    for (Tick& clock : now) clock += below(20);
    for (int i = 0; i < 60; ++i) {  // some sooner than before, some later, some over already
      const auto place = static_cast<std::uint32_t>(random() % kPlaces);
      for (std::size_t c = 0; c < kClocks; ++c)
        limits[place][c] = random() % 3 == 0 ? kForever : now[c] + below(400) - 5;
      ends.set(place, limits[place]);
    }
    std::vector<std::uint32_t> expected, ended;
    for (std::uint32_t place = 0; place < kPlaces; ++place) {
      if (alive(now, limits[place])) continue;
      expected.push_back(place);
      limits[place].fill(kForever);
    }
    ends.renew_ended(now, [&](std::uint32_t place) {
      ended.push_back(place);
      if (place % 3 == 0) limits[place] = {now[Move] + 7, now[Scale] + 50, kForever};
      return limits[place];
    });
    ASSERT_EQ(ended, expected) << frame;
    renewed += ended.size();
  }
  EXPECT_GT(renewed, 5000U);
  ends.clear();
  ends.renew_ended({kForever - 1, kForever - 1, kForever - 1}, [](std::uint32_t place) {
    ADD_FAILURE() << place;
    return RangeEnds::kNever;
  });
}

TEST(Odometer, ManyStepsBelowATickAgeRangesNoFasterLater) {
  Odometer odometer(1, Rounding::Exact);
  const auto steps_until_it_ends = [&](double allowance_m, double& x) {
    const Tick end = odometer.until({allowance_m, 1e30, 1e30})[Move];
    int steps = 0;
    while (odometer.now()[Move] < end) {
      const View view = make_view({.eye = {x += 0.04, 0, 500}}, 320, 240);
      odometer.advance(Criterion(view, ScreenError(view, 1)));
      ++steps;
    }
    return steps;
  };
  double x = 0;
  const View start = make_view({.eye = {0, 0, 500}}, 320, 240);
  odometer.advance(Criterion(start, ScreenError(start, 1)));
  const int first = steps_until_it_ends(100, x);
  EXPECT_GT(first, 90);
  EXPECT_LE(first, 2500);  // 100 m of 0.04 m: never later than the truth
  for (int i = 0; i < 40; ++i) EXPECT_NEAR(steps_until_it_ends(100, x), first, 2) << i;
}

TEST(CodeCounts, KnowsTheGreatest) {
  std::mt19937_64 random(8);
  CodeCounts counts;
  std::multiset<Code> held;
  for (int i = 0; i < 20000; ++i) {
    if (held.empty() || random() % 100 < (i < 10000 ? 55U : 40U)) {
      const auto code = static_cast<Code>(random() % (random() % 4 == 0 ? 65536 : 700));
      counts.add(code);
      held.insert(code);
    } else {
      auto which = held.begin();
      std::advance(which, static_cast<int>(random() % std::min<std::size_t>(held.size(), 50)));
      if (random() % 2 == 0) which = std::prev(held.end());
      counts.remove(*which);
      held.erase(which);
    }
    ASSERT_EQ(counts.greatest(), held.empty() ? 0 : *held.rbegin()) << i;
  }
  counts.clear();
  EXPECT_EQ(counts.greatest(), 0);
}

TEST(TriangleList, TheLastTakesThePlaceOfWhatGoes) {
  TriangleList list;
  for (std::uint32_t i = 0; i < 4; ++i) {
    EXPECT_EQ(list.add(), i);
    list.set(i, 10 + i, {3 * i, 3 * i + 1, 3 * i + 2});
  }
  EXPECT_EQ(list.remove(1), 13U);
  EXPECT_EQ(list.remove(2), 12U);  // itself
  const std::vector<std::uint32_t> left{0, 1, 2, 9, 10, 11};
  EXPECT_TRUE(std::ranges::equal(list.indices(), left));
}

}  // namespace
}  // namespace arete::lod::bintree
