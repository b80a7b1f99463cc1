#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <numeric>
#include <vector>

#include "arete/lod/bintree/odometer.h"

namespace arete::lod::bintree {

/// When live ranges end, so that those that ended are found without a look at the others: the least
/// limits of every 32 places and of every 1024. What METHODS 8.11 does with a timing wheel,
/// for three clocks at once.
class RangeEnds {
 public:
  static constexpr Ticks kNever{kForever, kForever, kForever};
  /// Takes the memory for so many places.
  void reserve(std::size_t places);
  /// Sets a place's limits.
  void set(std::uint32_t place, const Ticks& until);
  /// For every place whose range has ended, in ascending order: `renew(place)` gives its new
  /// limits, kNever to forget it. Cost: of them, and a look at every 1024th place. `renew` must not
  /// set().
  template <typename Renew>
  void renew_ended(const Ticks& now, Renew renew) {
    for (std::size_t i = 0; i < blocks_.back().size(); ++i) renew_in<kLevels - 1>(i, now, renew);
  }
  /// Forgets all.
  void clear();

 private:
  static constexpr std::size_t kFan = 32, kLevels = 3;
  /// The limits of 32 places, or the least ones of 32 blocks, by clock: what vector code likes.
  struct Block {
    std::array<std::array<Tick, kFan>, kClocks> until;
  };

  static const Block kNeverBlock;
  static Ticks least(const Block& block);
  static void put(Block& block, std::size_t k, const Ticks& until);
  static unsigned ended_in(const Block& block, const Ticks& now);

  template <std::size_t kLevel, typename Renew>
  void renew_in(std::size_t i, const Ticks& now, Renew& renew) {
    Block& block = blocks_[kLevel][i];
    for (unsigned left = ended_in(block, now); left != 0; left &= left - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(left));
      if constexpr (kLevel == 0) {
        put(block, k, renew(static_cast<std::uint32_t>(kFan * i + k)));
      } else {
        renew_in<kLevel - 1>(kFan * i + k, now, renew);
        put(block, k, least(blocks_[kLevel - 1][kFan * i + k]));
      }
    }
  }

  /// [0]: of places; place k of [n][i] is no later than any in [n - 1][32 i + k].
  std::array<std::vector<Block>, kLevels> blocks_;
};

inline Ticks RangeEnds::least(const Block& block) {
  Ticks out;
  for (std::size_t c = 0; c < kClocks; ++c) {
    Tick least = kForever;
    for (const Tick until : block.until[c]) least = std::min(least, until);
    out[c] = least;
  }
  return out;
}

inline void RangeEnds::put(Block& block, std::size_t k, const Ticks& until) {
  for (std::size_t c = 0; c < kClocks; ++c) block.until[c][k] = until[c];
}

// A bit for each of the 32. Loops of one operation each: compilers make vector code of them.
inline unsigned RangeEnds::ended_in(const Block& block, const Ticks& now) {
  constexpr std::array<Tick, kFan> kBits = [] {
    std::array<Tick, kFan> bits{};
    for (std::size_t k = 0; k < kFan; ++k) bits[k] = static_cast<Tick>(1U << k);
    return bits;
  }();
  const auto& until = block.until;
  std::array<Tick, kFan> left, bits;
  for (std::size_t k = 0; k < kFan; ++k) {
    const Tick move_scale = std::min(until[Move][k] - now[Move], until[Scale][k] - now[Scale]);
    left[k] = std::min(move_scale, until[Turn][k] - now[Turn]);
  }
  for (std::size_t k = 0; k < kFan; ++k) bits[k] = (left[k] <= 0 ? -1 : 0) & kBits[k];
  return static_cast<unsigned>(std::accumulate(bits.begin(), bits.end(), 0, std::bit_or<>()));
}

}  // namespace arete::lod::bintree
