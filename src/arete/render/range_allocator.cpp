#include "arete/render/range_allocator.h"

#include <algorithm>
#include <cassert>

namespace arete::render {

RangeAllocator::RangeAllocator(std::uint64_t size) : size_(size) {
  if (size > 0) free_.push_back({0, size});
}

void RangeAllocator::shrink(std::size_t index, std::uint64_t count) {
  free_[index].count -= count;
  taken_ += count;
  if (free_[index].count == 0) free_.erase(free_.begin() + static_cast<std::ptrdiff_t>(index));
}

std::optional<std::uint64_t> RangeAllocator::take(std::uint64_t count) {
  assert(count > 0);
  for (std::size_t i = 0; i < free_.size(); ++i) {
    if (free_[i].count < count) continue;
    const std::uint64_t first = free_[i].first;
    free_[i].first += count;
    shrink(i, count);
    return first;
  }
  return std::nullopt;
}

std::optional<std::uint64_t> RangeAllocator::take_last(std::uint64_t count) {
  assert(count > 0);
  for (std::size_t i = free_.size(); i-- > 0;) {
    if (free_[i].count < count) continue;
    const std::uint64_t first = free_[i].first + free_[i].count - count;
    shrink(i, count);
    return first;
  }
  return std::nullopt;
}

void RangeAllocator::give(std::uint64_t first, std::uint64_t count) {
  assert(count > 0 && first + count <= size_ && count <= taken_);
  taken_ -= count;
  auto next = std::lower_bound(free_.begin(), free_.end(), first,
                               [](const Range& r, std::uint64_t f) { return r.first < f; });
  const bool joins_next = next != free_.end() && next->first == first + count;
  const bool joins_previous =
      next != free_.begin() && std::prev(next)->first + std::prev(next)->count == first;
  if (joins_previous && joins_next) {
    std::prev(next)->count += count + next->count;
    free_.erase(next);
  } else if (joins_previous) {
    std::prev(next)->count += count;
  } else if (joins_next) {
    next->first = first;
    next->count += count;
  } else {
    free_.insert(next, {first, count});
  }
}

void RangeAllocator::grow(std::uint64_t new_size) {
  assert(new_size >= size_);
  const std::uint64_t added = new_size - size_;
  const std::uint64_t first = size_;
  size_ = new_size;
  if (added == 0) return;
  taken_ += added;
  give(first, added);
}

}  // namespace arete::render
