#include "arete/proof/pixel_histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace arete::proof {

void PixelHistogram::raise(double squared_px) {
  max_squared_ = std::isnan(squared_px) ? std::numeric_limits<double>::infinity() : squared_px;
}

void PixelHistogram::merge(const PixelHistogram& other) {
  for (std::size_t i = 0; i < bins_.size(); ++i) bins_[i] += other.bins_[i];
  count_ += other.count_;
  max_squared_ = std::max(max_squared_, other.max_squared_);
}

double PixelHistogram::max_px() const {
  return std::sqrt(max_squared_);
}

double PixelHistogram::quantile_px(double share) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t seen = bins_[0];
  if (seen >= wanted) return 0;
  for (std::size_t i = 1; i + 1 < bins_.size(); ++i) {
    seen += bins_[i];
    if (seen < wanted) continue;
    const auto end = static_cast<std::uint32_t>(i) + kFirst;
    return std::min(max_px(), std::sqrt(double{std::bit_cast<float>(end << kShift)}));
  }
  return max_px();
}

}  // namespace arete::proof
