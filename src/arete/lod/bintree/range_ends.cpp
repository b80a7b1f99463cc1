#include "arete/lod/bintree/range_ends.h"

#include <algorithm>

namespace arete::lod::bintree {
namespace {

constexpr Ticks kNever{kForever, kForever, kForever};

Ticks earlier(const Ticks& a, const Ticks& b) {
  return {std::min(a[Move], b[Move]), std::min(a[Scale], b[Scale]), std::min(a[Turn], b[Turn])};
}

}  // namespace

void RangeEnds::reserve(std::size_t places) {
  for (std::vector<Ticks>& level : least_) {
    places = (places + kFan - 1) / kFan * kFan;
    if (level.size() < places) level.resize(places, kNever);
    places /= kFan;
  }
}

void RangeEnds::clear() {
  for (std::vector<Ticks>& level : least_) std::ranges::fill(level, kNever);
}

void RangeEnds::set(std::uint32_t place, const Ticks& until) {
  if (place >= least_[0].size()) reserve(2 * (place + std::size_t{1}));
  least_[0][place] = until;
  std::size_t i = place;
  for (std::size_t level = 1; level < kLevels; ++level) {
    i /= kFan;
    least_[level][i] = earlier(least_[level][i], until);
  }
}

void RangeEnds::take_ended(const Ticks& now, std::vector<std::uint32_t>& ended) {
  std::vector<Ticks>& top = least_.back();
  for (std::size_t i = 0; i < top.size(); ++i) {
    if (!alive(now, top[i])) top[i] = take_below(kLevels - 1, i, now, ended);
  }
}

// Of the places below [level][i]; returns the least that is left there.
Ticks RangeEnds::take_below(std::size_t level, std::size_t i, const Ticks& now,
                            std::vector<std::uint32_t>& ended) {
  if (level == 0) {
    ended.push_back(static_cast<std::uint32_t>(i));
    return kNever;
  }
  Ticks least = kNever;
  for (std::size_t k = kFan * i; k < kFan * (i + 1); ++k) {
    Ticks& until = least_[level - 1][k];
    if (!alive(now, until)) until = take_below(level - 1, k, now, ended);
    least = earlier(least, until);
  }
  return least;
}

}  // namespace arete::lod::bintree
