#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "arete/lod/bintree/odometer.h"

namespace arete::lod::bintree {

/// When live ranges end, so that those that ended are found without a look at the others: the least
/// limits of every 8 places, of every 64, and so on. What METHODS 8.11 does with a timing wheel,
/// for three clocks at once.
class RangeEnds {
 public:
  /// Takes the memory for so many places.
  void reserve(std::size_t places);
  /// Sets a place's limits.
  void set(std::uint32_t place, const Ticks& until);
  /// Appends the places whose range has ended, in ascending order, and forgets them until they are
  /// set again. Cost: of them, and a look at every 512th place.
  void take_ended(const Ticks& now, std::vector<std::uint32_t>& ended);
  /// Forgets all.
  void clear();

 private:
  static constexpr std::size_t kFan = 8, kLevels = 4;
  /// The limits of 8 places, or the least ones of 8 blocks, by clock: what vector code likes.
  struct Block {
    std::array<std::array<Tick, kFan>, kClocks> until;
  };

  static const Block kNever;
  static Ticks least(const Block& block);
  static void put(Block& block, std::size_t k, const Ticks& until);
  static unsigned ended_in(const Block& block, const Ticks& now);
  void take_from(std::size_t level, std::size_t block, const Ticks& now,
                 std::vector<std::uint32_t>& ended);

  /// [0]: of places; place k of [n][i] is no later than any in [n - 1][8 i + k].
  std::array<std::vector<Block>, kLevels> blocks_;
};

}  // namespace arete::lod::bintree
