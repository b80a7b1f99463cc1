#pragma once

#include <compare>
#include <cstdint>

namespace arete {

/// A square of a pyramid. level = log2 of the post spacing, 0 = finest; x east, y south.
/// At every level tile (x, y) covers posts [x n, (x+1) n] of that level, n = cells a tile side.
struct TileId {
  std::uint32_t level = 0, x = 0, y = 0;

  TileId parent() const { return {level + 1, x / 2, y / 2}; }
  /// Child i in 0..3: NW, NE, SW, SE. Requires: level > 0.
  TileId child(int i) const {
    const auto u = static_cast<std::uint32_t>(i);
    return {level - 1, 2 * x + (u & 1U), 2 * y + (u >> 1U)};
  }
  /// Sorted by level, then row, then column: 8 bits level, 28 bits y, 28 bits x.
  std::uint64_t key() const {
    return (std::uint64_t{level} << 56U) | (std::uint64_t{y} << 28U) | std::uint64_t{x};
  }
  static TileId from_key(std::uint64_t k) {
    return {static_cast<std::uint32_t>(k >> 56U), static_cast<std::uint32_t>(k & 0xFFFFFFFU),
            static_cast<std::uint32_t>((k >> 28U) & 0xFFFFFFFU)};
  }
  friend auto operator<=>(const TileId&, const TileId&) = default;
};

}  // namespace arete
