#pragma once

#include <cstdint>
#include <span>

#include "arete/core/height_source.h"

namespace arete::store {

/// The integers that all heights of a store are kept as: z = offset_m + quantum_m * count.
struct Lattice {
  double quantum_m = 0, offset_m = 0;
  friend bool operator==(const Lattice&, const Lattice&) = default;
};

/// Counts stay within +-kMaxCount, so that differences of two fit 32 bits.
inline constexpr std::int32_t kMaxCount = (1 << 30) - 1;

/// The source's own lattice, or 2^-10 m for heights that are not integers.
Lattice first_lattice(const HeightLattice& source);
/// The finest power of two, at least 2^-10 m, that holds heights of this magnitude.
Lattice lattice_for_magnitude(double z_abs_max_m);

/// What a row of heights came to. Merging is independent of order.
struct RowStats {
  std::int64_t valid = 0;
  std::int32_t count_min = kMaxCount, count_max = -kMaxCount;
  float max_error_m = 0;  ///< largest |stored - source|, both as float
  float z_abs_max = 0;
  void merge(const RowStats& other);
};

/// Heights to counts; NaN and infinities become kAbsent. False when a height does not fit the
/// lattice; `counts` then mean nothing.
bool quantize_row(const Lattice& lattice, std::span<const float> z, std::span<std::int32_t> counts,
                  RowStats& stats);

}  // namespace arete::store
