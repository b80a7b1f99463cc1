#include "arete/raster/values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::raster {
namespace {

constexpr double kFootM = 0.3048;
constexpr double kUsSurveyFootM = 1200.0 / 3937.0;
constexpr double kFarthestM = 1e6;
// Usual spellings of "no data" that could also be heights.
constexpr std::array<double, 5> kSuspects = {-32768, -32767, -9999, -99999, 65535};

struct UnitName {
  std::string_view name;
  double metres;
};
constexpr std::array kUnitNames = {
    UnitName{"m", 1},
    UnitName{"metre", 1},
    UnitName{"metres", 1},
    UnitName{"meter", 1},
    UnitName{"meters", 1},
    UnitName{"ft", kFootM},
    UnitName{"foot", kFootM},
    UnitName{"feet", kFootM},
    UnitName{"international feet", kFootM},
    UnitName{"us-ft", kUsSurveyFootM},
    UnitName{"sfoot", kUsSurveyFootM},
    UnitName{"us survey foot", kUsSurveyFootM},
    UnitName{"us survey feet", kUsSurveyFootM},
    UnitName{"foot_us", kUsSurveyFootM},
    UnitName{"ftus", kUsSurveyFootM},
    UnitName{"km", 1000},
    UnitName{"dm", 0.1},
    UnitName{"cm", 0.01},
    UnitName{"mm", 0.001},
};

std::optional<double> named_unit(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) {
    return c < 128 ? static_cast<char>(std::tolower(c)) : static_cast<char>(c);
  });
  for (const UnitName& unit : kUnitNames) {
    if (unit.name == name) return unit.metres;
  }
  return std::nullopt;
}

// The vertical axis of a compound CRS names a unit even when the band does not.
std::optional<double> vertical_crs_unit(GDALRasterBand& band) {
  const OGRSpatialReference* crs =
      band.GetDataset() == nullptr ? nullptr : band.GetDataset()->GetSpatialRef();
  if (crs == nullptr || crs->IsVertical() == 0) return std::nullopt;
  const double metres = crs->GetTargetLinearUnits("VERT_CS");
  return std::isfinite(metres) && metres > 0 ? std::optional(metres) : std::nullopt;
}

double chosen_unit_m(Unit unit) {
  if (unit == Unit::Foot) return kFootM;
  return unit == Unit::UsSurveyFoot ? kUsSurveyFootM : 1;
}

double unit_in_metres(GDALRasterBand& band, Unit unit, std::vector<std::string>& notes) {
  if (unit != Unit::FromFile) return chosen_unit_m(unit);
  const std::string name = band.GetUnitType();
  if (name.empty()) return vertical_crs_unit(band).value_or(1);
  if (const auto metres = named_unit(name)) return *metres;
  notes.push_back(fmt::format("The unit '{}' is not a known length: metres were assumed.", name));
  return 1;
}

std::optional<double> declared_nodata(GDALRasterBand& band) {
  int present = 0;
  double value = 0;
  if (band.GetRasterDataType() == GDT_Int64) {
    value = static_cast<double>(band.GetNoDataValueAsInt64(&present));
  } else if (band.GetRasterDataType() == GDT_UInt64) {
    value = static_cast<double>(band.GetNoDataValueAsUInt64(&present));
  } else {
    value = band.GetNoDataValue(&present);
  }
  return present != 0 ? std::optional(value) : std::nullopt;
}

// The closed range of samples that count as `nodata`: one integer, or a float and its neighbours.
template <class T>
struct Range {
  T low = std::numeric_limits<T>::max();
  T high = std::numeric_limits<T>::lowest();  // low > high: empty
};

template <class T>
Range<T> nodata_range(double nodata) {
  using Limits = std::numeric_limits<T>;
  if constexpr (std::is_floating_point_v<T>) {
    if (std::isnan(nodata)) return {};
    const double bound = static_cast<double>(Limits::max());
    const T centre =
        static_cast<T>(std::isinf(nodata) ? nodata : std::clamp(nodata, -bound, bound));
    return {std::nextafter(centre, -Limits::infinity()),
            std::nextafter(centre, Limits::infinity())};
  } else {
    // The upper limit as a double may be one too many for 64 bits, hence "<".
    const double above = std::ldexp(1.0, Limits::digits);
    if (!(nodata >= static_cast<double>(Limits::lowest()) && nodata < above)) return {};
    if (nodata != std::floor(nodata)) return {};
    return {static_cast<T>(nodata), static_cast<T>(nodata)};
  }
}

// Looked for only in rows whose samples reach that far: most never do.
template <class T>
void count_suspects(std::span<const T> samples, const std::vector<Range<T>>& nodata, Tally& tally) {
  for (std::size_t k = 0; k < kSuspects.size(); ++k) {
    const Range<T> range = nodata_range<T>(kSuspects[k]);
    if (!(range.low <= range.high)) continue;
    const T value = static_cast<T>(kSuspects[k]);
    const bool declared = std::any_of(nodata.begin(), nodata.end(), [&](const Range<T>& r) {
      return value >= r.low && value <= r.high;
    });
    if (!declared) tally.spelt[k] += std::count(samples.begin(), samples.end(), value);
  }
}

// Infinite and far ones that nothing declares to be no data.
template <class T>
std::int64_t count_beyond(std::span<const T> samples, const std::vector<Range<T>>& nodata,
                          const ValueRule& rule) {
  return std::count_if(samples.begin(), samples.end(), [&](T v) {
    const double z = static_cast<double>(v) * rule.step_m + rule.offset_m;
    const bool declared = std::any_of(nodata.begin(), nodata.end(),
                                      [&](const Range<T>& r) { return v >= r.low && v <= r.high; });
    return !declared && std::abs(z) > rule.limit_m;
  });
}

// The loop has no branches and no counters, so that compilers vectorise it; what is rare is
// counted in a second pass over the rows that have it.
template <class T>
void decode_as(const ValueRule& rule, const std::byte* bytes, std::span<float> out, Tally& tally) {
  const std::span<const T> samples(reinterpret_cast<const T*>(bytes), out.size());
  std::vector<Range<T>> nodata;
  for (const double value : rule.nodata) nodata.push_back(nodata_range<T>(value));
  const Range<T> first = nodata.empty() ? Range<T>{} : nodata[0];
  const Range<T> second = nodata.size() < 2 ? Range<T>{} : nodata[1];
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const double step = rule.step_m, offset = rule.offset_m, limit = rule.limit_m;
  int any_far = 0, any_extreme = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const T v = samples[i];
    const double raw = static_cast<double>(v);
    const double z = raw * step + offset;
    const int declared =
        ((v >= first.low) & (v <= first.high)) | ((v >= second.low) & (v <= second.high));
    const int near = std::abs(z) <= limit;
    any_far |= near ^ 1;
    any_extreme |= (raw <= -9999) | (raw >= 65535);
    out[i] = (declared | (near ^ 1)) != 0 ? kNone : static_cast<float>(z);
  }
  tally.posts += static_cast<std::int64_t>(out.size());
  if (any_far != 0) tally.beyond += count_beyond(samples, nodata, rule);
  if (any_extreme != 0) count_suspects(samples, nodata, tally);
}

// The largest |height| that samples of the type can stand for.
double reach_m(const ValueRule& rule) {
  double samples = kFarthestM;
  if (rule.type == GDT_Byte) samples = 255;
  if (rule.type == GDT_Int16 || rule.type == GDT_UInt16) samples = 65535;
  if (samples == kFarthestM) return rule.limit_m;
  return std::min(rule.limit_m, std::abs(rule.offset_m) + samples * std::abs(rule.step_m));
}

}  // namespace

HeightLattice lattice_of(double step_m, double offset_m, double reach_m) {
  const auto reach = static_cast<float>(reach_m);
  const double float_gap =
      static_cast<double>(reach) - static_cast<double>(std::nextafter(reach, 0.0F));
  if (!(float_gap < std::abs(step_m))) return {};
  return {.integer = true, .step_m = std::abs(step_m), .offset_m = offset_m};
}

HeightLattice ValueRule::lattice() const {
  if (GDALDataTypeIsInteger(type) == 0) return {};
  return lattice_of(step_m, offset_m, reach_m(*this));
}

ValueRule plain_rule(GDALDataType type, const DemOptions& options) {
  ValueRule rule;
  rule.type = type;
  rule.step_m = chosen_unit_m(options.unit) * options.z_scale;
  rule.limit_m = kFarthestM * std::abs(options.z_scale);
  if (options.nodata) rule.nodata.push_back(*options.nodata);
  return rule;
}

ValueRule value_rule(GDALRasterBand& band, const DemOptions& options, const std::string& name,
                     std::vector<std::string>& notes) {
  ValueRule rule;
  rule.type = band.GetRasterDataType();
  if (rule.type == GDT_Unknown || GDALDataTypeIsComplex(rule.type) != 0) {
    throw Error(ErrorCode::Unsupported,
                fmt::format("{}: its samples are complex numbers: name another --band", name));
  }
  const char* pixel_type = band.GetMetadataItem("PIXELTYPE", "IMAGE_STRUCTURE");
  rule.signed_byte = pixel_type != nullptr && std::string_view(pixel_type) == "SIGNEDBYTE";
  const double unit = unit_in_metres(band, options.unit, notes) * options.z_scale;
  double scale = band.GetScale();
  double offset = band.GetOffset();
  if (!std::isfinite(scale) || scale == 0 || !std::isfinite(offset)) {
    notes.emplace_back("The file's scale or offset is not a number: ignored.");
    scale = 1;
    offset = 0;
  }
  rule.step_m = scale * unit;
  rule.offset_m = offset * unit;
  rule.limit_m = kFarthestM * std::abs(options.z_scale);
  if (const auto nodata = declared_nodata(band)) rule.nodata.push_back(*nodata);
  if (options.nodata) rule.nodata.push_back(*options.nodata);
  return rule;
}

void decode(const ValueRule& rule, const std::byte* samples, std::span<float> out, Tally& tally) {
  switch (rule.type) {
    case GDT_Byte:
      if (rule.signed_byte) return decode_as<std::int8_t>(rule, samples, out, tally);
      return decode_as<std::uint8_t>(rule, samples, out, tally);
    case GDT_Int16:
      return decode_as<std::int16_t>(rule, samples, out, tally);
    case GDT_UInt16:
      return decode_as<std::uint16_t>(rule, samples, out, tally);
    case GDT_Int32:
      return decode_as<std::int32_t>(rule, samples, out, tally);
    case GDT_UInt32:
      return decode_as<std::uint32_t>(rule, samples, out, tally);
    case GDT_Int64:
      return decode_as<std::int64_t>(rule, samples, out, tally);
    case GDT_UInt64:
      return decode_as<std::uint64_t>(rule, samples, out, tally);
    case GDT_Float64:
      return decode_as<double>(rule, samples, out, tally);
    default:
      return decode_as<float>(rule, samples, out, tally);
  }
}

std::vector<std::string> describe(const Tally& tally) {
  std::vector<std::string> notes;
  if (tally.posts == 0) return notes;
  if (tally.beyond > 0) {
    notes.push_back(
        fmt::format("{} of {} posts read are infinite or beyond 1e6 m and count as no data.",
                    tally.beyond, tally.posts));
  }
  for (std::size_t k = 0; k < kSuspects.size(); ++k) {
    if (tally.spelt[k] == 0) continue;
    notes.push_back(fmt::format(
        "{} of {} posts read hold {}, often meant as no data but not declared so: kept as heights; "
        "with --nodata {} they are none.",
        tally.spelt[k], tally.posts, kSuspects[k], kSuspects[k]));
  }
  return notes;
}

}  // namespace arete::raster
