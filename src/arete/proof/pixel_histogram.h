#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace arete::proof {

/// Distribution of distances in pixels, told by their squares. Quantiles are rounded up to the
/// end of their bin: at most 0.4 % too large, exact at 0 and at the maximum. Below 2^-20 px all is
/// 0; infinity is kept.
class PixelHistogram {
 public:
  /// squared_px >= 0; a NaN counts as infinite.
  void add_squared(double squared_px) {
    if (!(squared_px <= max_squared_)) raise(squared_px);
    ++bins_[bin_of(static_cast<float>(squared_px))];
    ++count_;
  }
  void merge(const PixelHistogram& other);

  std::uint64_t count() const { return count_; }
  double max_px() const;
  /// The smallest value that `share` of all values do not exceed; 0 when empty.
  double quantile_px(double share) const;

 private:
  // Bins are the leading bits of a float: exponent and 7 bits of fraction.
  static constexpr unsigned kShift = 16;
  static constexpr std::uint32_t kFirst = (127U - 40U) << 7U;
  static constexpr std::uint32_t kLast = (127U + 64U) << 7U;

  static std::size_t bin_of(float squared) {
    const std::uint32_t code = std::bit_cast<std::uint32_t>(squared) >> kShift;
    return code < kFirst ? 0 : std::min(code, kLast) - kFirst + 1;
  }
  void raise(double squared_px);

  std::array<std::uint64_t, kLast - kFirst + 2> bins_{};
  std::uint64_t count_ = 0;
  double max_squared_ = 0;
};

}  // namespace arete::proof
