#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "arete/lod/bintree/record.h"

namespace arete::lod::bintree {

/// How many there are of each code, and hence the greatest: no step depends on how many codes there
/// are.
class CodeCounts {
 public:
  void add(Code code) {
    if (counts_[code]++ > 0) return;
    words_[code / 64U] |= bit(code);
    groups_[code / 4096U] |= bit(code / 64U);
  }
  /// Requires: the code was added and is still there.
  void remove(Code code) {
    if (--counts_[code] > 0) return;
    if ((words_[code / 64U] &= ~bit(code)) == 0) groups_[code / 4096U] &= ~bit(code / 64U);
  }
  /// 0 when there is none.
  Code greatest() const {
    for (std::size_t g = kGroups; g-- > 0;) {
      if (groups_[g] == 0) continue;
      const std::size_t word = 64 * g + highest(groups_[g]);
      return static_cast<Code>(64 * word + highest(words_[word]));
    }
    return 0;
  }

  void clear() {
    std::ranges::fill(counts_, 0);
    std::ranges::fill(words_, 0);
    groups_.fill(0);
  }

 private:
  static constexpr std::size_t kCodes = std::size_t{1} << 16U, kGroups = kCodes / 4096;

  static std::uint64_t bit(unsigned i) { return std::uint64_t{1} << (i % 64U); }
  static std::size_t highest(std::uint64_t word) {
    return static_cast<std::size_t>(std::bit_width(word)) - 1;
  }

  std::vector<std::uint32_t> counts_ = std::vector<std::uint32_t>(kCodes);
  std::vector<std::uint64_t> words_ = std::vector<std::uint64_t>(kCodes / 64);
  std::array<std::uint64_t, kGroups> groups_{};
};

}  // namespace arete::lod::bintree
