#include "arete/store/lattice.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "arete/store/height_patch.h"

namespace arete::store {
namespace {

constexpr double kFinestQuantum = 1.0 / 1024;
constexpr std::uint32_t kSignBit = 0x80000000U;
constexpr std::uint32_t kInfinity = 0x7F800000U;
// Added to a double of magnitude below 2^51 it leaves the rounded integer in the low bits.
constexpr double kRounder = 6755399441055744.0;  // 1.5 * 2^52

std::int32_t max_of(std::int32_t a, std::int32_t b) {
  return a > b ? a : b;
}
std::int32_t min_of(std::int32_t a, std::int32_t b) {
  return a < b ? a : b;
}

}  // namespace

Lattice first_lattice(const HeightLattice& source) {
  const bool usable = source.integer && std::isfinite(source.step_m) && source.step_m > 0 &&
                      std::isfinite(source.offset_m);
  return usable ? Lattice{source.step_m, source.offset_m} : Lattice{kFinestQuantum, 0};
}

Lattice lattice_for_magnitude(double z_abs_max_m) {
  double quantum = kFinestQuantum;
  while (z_abs_max_m / quantum > kMaxCount / 2) quantum *= 2;
  return {quantum, 0};
}

void RowStats::merge(const RowStats& other) {
  valid += other.valid;
  count_min = std::min(count_min, other.count_min);
  count_max = std::max(count_max, other.count_max);
  max_error_m = std::max(max_error_m, other.max_error_m);
  z_abs_max = std::max(z_abs_max, other.z_abs_max);
}

// Branch-free, and reductions in integers only (floats >= 0 order as their bits do), so that the
// compiler turns it into vector code without licence to change the arithmetic.
bool quantize_row(const Lattice& lattice, std::span<const float> z, std::span<std::int32_t> counts,
                  RowStats& stats) {
  const double scale = 1 / lattice.quantum_m;
  const float* in = z.data();
  std::int32_t* out = counts.data();
  std::int32_t valid = 0;
  std::int32_t least = kMaxCount;
  std::int32_t most = -kMaxCount;
  std::int32_t error_bits = 0;
  std::int32_t magnitude_bits = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const auto magnitude =
        static_cast<std::int32_t>(std::bit_cast<std::uint32_t>(in[i]) & ~kSignBit);
    const bool ok = magnitude < static_cast<std::int32_t>(kInfinity);
    const double shifted = (static_cast<double>(in[i]) - lattice.offset_m) * scale + kRounder;
    const auto count = static_cast<std::int32_t>(std::bit_cast<std::int64_t>(shifted));
    const auto back =
        static_cast<float>(lattice.offset_m + lattice.quantum_m * (shifted - kRounder));
    const auto error =
        static_cast<std::int32_t>(std::bit_cast<std::uint32_t>(back - in[i]) & ~kSignBit);
    valid += ok ? 1 : 0;
    least = min_of(least, ok ? count : kMaxCount);
    most = max_of(most, ok ? count : -kMaxCount);
    error_bits = max_of(error_bits, ok ? error : 0);
    magnitude_bits = max_of(magnitude_bits, ok ? magnitude : 0);
    out[i] = ok ? count : kAbsent;
  }
  const RowStats row{valid, least, most, std::bit_cast<float>(error_bits),
                     std::bit_cast<float>(magnitude_bits)};
  stats.merge(row);
  const double reach = (static_cast<double>(row.z_abs_max) + std::abs(lattice.offset_m)) * scale;
  return reach < kMaxCount;
}

}  // namespace arete::store
