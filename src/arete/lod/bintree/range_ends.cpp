#include "arete/lod/bintree/range_ends.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <numeric>

namespace arete::lod::bintree {

const RangeEnds::Block RangeEnds::kNever = [] {
  Block block;
  for (auto& lane : block.until) lane.fill(kForever);
  return block;
}();

void RangeEnds::reserve(std::size_t places) {
  for (std::vector<Block>& level : blocks_) {
    places = (places + kFan - 1) / kFan;
    if (level.size() < places) level.resize(places, kNever);
  }
}

void RangeEnds::clear() {
  for (std::vector<Block>& level : blocks_) std::ranges::fill(level, kNever);
}

Ticks RangeEnds::least(const Block& block) {
  Ticks out;
  for (std::size_t c = 0; c < kClocks; ++c) {
    Tick least = kForever;
    for (const Tick until : block.until[c]) least = std::min(least, until);
    out[c] = least;
  }
  return out;
}

void RangeEnds::put(Block& block, std::size_t k, const Ticks& until) {
  for (std::size_t c = 0; c < kClocks; ++c) block.until[c][k] = until[c];
}

// A bit for each of the 8. Loops of one operation each: compilers make vector code of them.
unsigned RangeEnds::ended_in(const Block& block, const Ticks& now) {
  constexpr std::array<Tick, kFan> kBits{1, 2, 4, 8, 16, 32, 64, 128};
  const auto& until = block.until;
  std::array<Tick, kFan> left, bits;
  for (std::size_t k = 0; k < kFan; ++k) {
    const Tick move_scale = std::min(until[Move][k] - now[Move], until[Scale][k] - now[Scale]);
    left[k] = std::min(move_scale, until[Turn][k] - now[Turn]);
  }
  for (std::size_t k = 0; k < kFan; ++k) bits[k] = (left[k] <= 0 ? -1 : 0) & kBits[k];
  return static_cast<unsigned>(std::accumulate(bits.begin(), bits.end(), 0, std::bit_or<>()));
}

void RangeEnds::set(std::uint32_t place, const Ticks& until) {
  if (place / kFan >= blocks_[0].size()) reserve(2 * (place + std::size_t{1}));
  std::size_t i = place;
  put(blocks_[0][i / kFan], i % kFan, until);
  for (std::size_t level = 1; level < kLevels; ++level) {
    i /= kFan;
    Block& block = blocks_[level][i / kFan];
    for (std::size_t c = 0; c < kClocks; ++c)
      block.until[c][i % kFan] = std::min(block.until[c][i % kFan], until[c]);
  }
}

void RangeEnds::take_ended(const Ticks& now, std::vector<std::uint32_t>& ended) {
  for (std::size_t i = 0; i < blocks_.back().size(); ++i) take_from(kLevels - 1, i, now, ended);
}

void RangeEnds::take_from(std::size_t level, std::size_t i, const Ticks& now,
                          std::vector<std::uint32_t>& ended) {
  Block& block = blocks_[level][i];
  for (unsigned left = ended_in(block, now); left != 0; left &= left - 1) {
    const auto k = static_cast<std::size_t>(std::countr_zero(left));
    if (level == 0) {
      ended.push_back(static_cast<std::uint32_t>(kFan * i + k));
      put(block, k, {kForever, kForever, kForever});
    } else {
      take_from(level - 1, kFan * i + k, now, ended);
      put(block, k, least(blocks_[level - 1][kFan * i + k]));
    }
  }
}

}  // namespace arete::lod::bintree
