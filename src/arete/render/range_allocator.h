#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace arete::render {

/// First-fit allocator of ranges of [0, size) that merges what is given back. Units are the
/// caller's. Cost: O(free ranges).
class RangeAllocator {
 public:
  explicit RangeAllocator(std::uint64_t size);
  /// The lowest range that fits. Requires: count > 0.
  std::optional<std::uint64_t> take(std::uint64_t count);
  /// The end of the highest range that fits: for what lives one frame, away from what stays.
  std::optional<std::uint64_t> take_last(std::uint64_t count);
  /// Requires: a range that was taken and not given back.
  void give(std::uint64_t first, std::uint64_t count);
  /// Adds [size, new_size). Requires: new_size >= size().
  void grow(std::uint64_t new_size);
  std::uint64_t size() const { return size_; }
  std::uint64_t taken() const { return taken_; }

 private:
  struct Range {
    std::uint64_t first, count;
  };
  void shrink(std::size_t index, std::uint64_t count);
  std::vector<Range> free_;  // ascending, never touching each other
  std::uint64_t size_, taken_ = 0;
};

}  // namespace arete::render
