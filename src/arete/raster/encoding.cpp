#include "arete/raster/encoding.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace arete::raster {
namespace {

struct Code {
  double step, offset;  ///< of the 24-bit number RGB
};

Code code_of(Encoding encoding) {
  if (encoding == Encoding::TerrainRgb) return {0.1, -10000};
  return {1.0 / 256, -32768};
}

}  // namespace

void decode_colours(Encoding encoding, int bands, const ValueRule& rule, const std::byte* samples,
                    std::span<float> out) {
  const Code code = code_of(encoding);
  const auto at = [&](std::size_t i) { return std::to_integer<std::uint32_t>(samples[i]); };
  const auto stride = static_cast<std::size_t>(bands);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::size_t s = i * stride;
    const std::uint32_t number = (at(s) << 16U) | (at(s + 1) << 8U) | at(s + 2);
    const double z = code.offset + code.step * number;
    const bool none = (bands == 4 && at(s + 3) == 0) ||
                      std::any_of(rule.nodata.begin(), rule.nodata.end(),
                                  [&](double v) { return std::abs(v - z) < code.step / 2; });
    out[i] = none ? std::numeric_limits<float>::quiet_NaN()
                  : static_cast<float>(z * rule.step_m + rule.offset_m);
  }
}

HeightLattice encoding_lattice(Encoding encoding, const ValueRule& rule) {
  const Code code = code_of(encoding);
  const double highest = std::max(-code.offset, code.offset + code.step * 0xFFFFFF);
  const double reach = std::min(rule.limit_m, highest * std::abs(rule.step_m));
  return lattice_of(code.step * rule.step_m, code.offset * rule.step_m, reach);
}

}  // namespace arete::raster
