#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <gdal_priv.h>

#include "arete/core/height_source.h"
#include "arete/raster/dem.h"

namespace arete::raster {

/// Counts of what was met in the rows decoded so far.
struct Tally {
  std::int64_t posts = 0;
  std::int64_t beyond = 0;              ///< infinite or further than 1e6 m from 0; not NaN
  std::array<std::int64_t, 5> spelt{};  ///< undeclared values of kSuspects, kept as data
};

/// How samples of one band become metres.
struct ValueRule {
  GDALDataType type = GDT_Float32;
  bool signed_byte = false;    ///< GDAL 3.6 shows signed bytes as Byte with a flag
  double step_m = 1;           ///< metres a sample unit, exaggeration included
  double offset_m = 0;         ///< metres
  double limit_m = 1e6;        ///< further from 0 there are no data
  std::vector<double> nodata;  ///< in sample units
  HeightLattice lattice() const;
};

/// The rule of a band under the options; notes get a sentence for what was assumed. Throws:
/// Unsupported for complex samples.
ValueRule value_rule(GDALRasterBand& band, const DemOptions& options, const std::string& name,
                     std::vector<std::string>& notes);

/// The rule of samples that nothing is declared about.
ValueRule plain_rule(GDALDataType type, const DemOptions& options);

/// Metres of out.size() samples of rule.type at `samples`; NaN = no data.
void decode(const ValueRule& rule, const std::byte* samples, std::span<float> out, Tally& tally);

/// One sentence for each finding.
std::vector<std::string> describe(const Tally& tally);

/// The lattice on which heights are offset + step * integer, when float keeps its points apart up
/// to `reach_m` from 0; else not integer.
HeightLattice lattice_of(double step_m, double offset_m, double reach_m);

}  // namespace arete::raster
