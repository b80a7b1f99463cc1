#include "arete/raster/placement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string_view>
#include <utility>

#include <cpl_conv.h>
#include <cpl_string.h>
#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::raster {
namespace {

constexpr double kWgs84RadiusM = 6378137;
constexpr std::size_t kMaxCrsBytes = 64U << 10U;

// Post (0,0) is the centre of pixel (0,0); GDAL has turned PixelIsPoint into corners already.
Affine2 post_centres(const std::array<double, 6>& gt) {
  return {
      {gt[1], gt[2], gt[0] + gt[1] / 2 + gt[2] / 2, gt[4], gt[5], gt[3] + gt[4] / 2 + gt[5] / 2}};
}

bool usable(const Affine2& a) {
  const bool finite =
      std::all_of(a.m.begin(), a.m.end(), [](double v) { return std::isfinite(v); });
  return finite && std::isnormal(a.determinant());
}

void flip_rows(Affine2& a, int rows) {
  a.m[2] += a.m[1] * (rows - 1);
  a.m[5] += a.m[4] * (rows - 1);
  a.m[1] = -a.m[1];
  a.m[4] = -a.m[4];
}

void flip_cols(Affine2& a, int cols) {
  a.m[2] += a.m[0] * (cols - 1);
  a.m[5] += a.m[3] * (cols - 1);
  a.m[0] = -a.m[0];
  a.m[3] = -a.m[3];
}

// Upright grids get row 0 north and column 0 west; quarter-turned ones only lose a mirroring.
void turn_north_up(Placement& placement, int cols, int rows) {
  Affine2& a = placement.georef.crs_from_post;
  const bool upright = std::abs(a.m[0]) + std::abs(a.m[4]) >= std::abs(a.m[1]) + std::abs(a.m[3]);
  placement.flip_rows = upright ? a.m[4] > 0 : a.determinant() > 0;
  placement.flip_cols = upright && a.m[0] < 0;
  if (placement.flip_rows) flip_rows(a, rows);
  if (placement.flip_cols) flip_cols(a, cols);
}

bool is_web_mercator(const OGRSpatialReference& crs) {
  const char* code = crs.GetAuthorityCode(nullptr);
  if (code != nullptr && std::string_view(code) == "3857") return true;
  const char* name = crs.GetName();
  return name != nullptr && std::strstr(name, "Pseudo-Mercator") != nullptr;
}

double radius_m(const OGRSpatialReference& crs) {
  OGRErr error = OGRERR_NONE;
  const double radius = crs.GetSemiMajor(&error);
  return error == OGRERR_NONE && std::isfinite(radius) && radius > 1 ? radius : kWgs84RadiusM;
}

// Metres for one CRS unit along x and y at the centre of the grid.
std::pair<double, double> metres_per_unit(const OGRSpatialReference& crs, double centre_y) {
  if (crs.IsGeographic() != 0) {
    const double radian = crs.GetAngularUnits();
    const double dy = radius_m(crs) * radian;
    return {dy * std::max(0.01, std::cos(centre_y * radian)), dy};
  }
  const double unit = crs.GetLinearUnits();
  const double metres = std::isfinite(unit) && unit > 0 ? unit : 1;
  if (!is_web_mercator(crs)) return {metres, metres};
  // The scale of Mercator at latitude phi is 1/cos phi = cosh(y / R).
  const double k = metres / std::cosh(centre_y * metres / radius_m(crs));
  return {k, k};
}

std::string export_wkt(const OGRSpatialReference& crs) {
  char* text = nullptr;
  const char* const options[] = {"FORMAT=WKT2_2019", nullptr};
  std::string wkt;
  if (crs.exportToWkt(&text, options) == OGRERR_NONE && text != nullptr) wkt = text;
  CPLFree(text);
  return wkt;
}

std::string short_name(const OGRSpatialReference& crs) {
  const char* name = crs.GetName();
  const char* authority = crs.GetAuthorityName(nullptr);
  const char* code = crs.GetAuthorityCode(nullptr);
  std::string text = name != nullptr ? name : "unnamed";
  if (text == "unknown" || text == "unnamed") {
    const char* projection = crs.GetAttrValue("PROJECTION");
    return fmt::format("{} on a body of radius {:.0f} m",
                       projection != nullptr ? projection : "longitude and latitude",
                       radius_m(crs));
  }
  if (authority == nullptr || code == nullptr) return text;
  return fmt::format("{} ({}:{})", text, authority, code);
}

bool in_degree_range(const Affine2& a, int cols, int rows) {
  for (const int c : {0, cols - 1}) {
    for (const int r : {0, rows - 1}) {
      const glm::dvec2 p = a.apply(c, r);
      if (std::abs(p.x) > 720 || std::abs(p.y) > 90.0001) return false;
    }
  }
  return true;
}

bool names_degrees(GDALDataset& dataset) {
  bool east = false, north = false;
  char** items = dataset.GetMetadata();
  for (int i = 0; items != nullptr && items[i] != nullptr; ++i) {
    std::string item = items[i];
    std::transform(item.begin(), item.end(), item.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    east = east || item.find("#units=degrees_e") != item.npos || item.starts_with("lon#") ||
           item.starts_with("longitude#");
    north = north || item.find("#units=degrees_n") != item.npos || item.starts_with("lat#") ||
            item.starts_with("latitude#");
  }
  return east && north;
}

// Grids without a CRS whose axes say degrees, that go round the globe, or whose spacing would be
// below 1 cm as metres.
bool looks_geographic(GDALDataset& dataset, const Affine2& a) {
  const int cols = dataset.GetRasterXSize();
  const int rows = dataset.GetRasterYSize();
  if (!in_degree_range(a, cols, rows)) return false;
  const bool netcdf = std::string_view(dataset.GetDriverName()) == "netCDF";
  if (netcdf && names_degrees(dataset)) return true;
  const double dx = std::hypot(a.m[0], a.m[3]);
  const double dy = std::hypot(a.m[1], a.m[4]);
  if (std::abs(dx * cols - 360) <= 1.5 * dx && dy * rows > 90) return true;
  return dx < 0.01 && dy < 0.01;
}

// Axes kept as floats: the outermost posts go to the nearest tenth of an arc-second if that is
// within what a float can tell apart.
void mend_float_axis(double& first, double& step, int count) {
  if (count < 2) return;
  const auto mended = [](double v) {
    const double tenth = std::round(v * 36000) / 36000;
    return std::abs(tenth - v) <= 4e-6 ? tenth : v;
  };
  const double last = mended(first + step * (count - 1));
  first = mended(first);
  step = (last - first) / (count - 1);
}

void mend_float_axes(Affine2& a, int cols, int rows) {
  if (a.m[1] != 0 || a.m[3] != 0) return;
  mend_float_axis(a.m[2], a.m[0], cols);
  mend_float_axis(a.m[5], a.m[4], rows);
}

}  // namespace

std::optional<Affine2> pixel_centres(GDALDataset& dataset) {
  std::array<double, 6> gt{};
  if (dataset.GetGeoTransform(gt.data()) != CE_None) return std::nullopt;
  const Affine2 affine = post_centres(gt);
  return usable(affine) ? std::optional(affine) : std::nullopt;
}

Georef unit_georef() {
  Georef georef;
  georef.world_from_post = georef.crs_from_post = Affine2{};
  return georef;
}

OGRSpatialReference parse_crs(const std::string& text, const std::string& name) {
  OGRSpatialReference crs;
  crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  if (text.size() > kMaxCrsBytes ||
      crs.SetFromUserInput(text.c_str(),
                           OGRSpatialReference::SET_FROM_USER_INPUT_LIMITATIONS_get()) !=
          OGRERR_NONE) {
    throw Error(ErrorCode::InvalidInput,
                fmt::format("{}: '{}' names no coordinate reference system: write EPSG:N", name,
                            text.substr(0, 80)));
  }
  // Heights are metres by the time anybody asks: only the horizontal part is wanted.
  if (crs.IsCompound() != 0) crs.StripVertical();
  return crs;
}

void fill_world(Georef& georef, int cols, int rows, const OGRSpatialReference* crs) {
  const Affine2& a = georef.crs_from_post;
  double kx = 1, ky = 1;
  if (crs != nullptr) {
    const double centre_y = a.apply((cols - 1) / 2.0, (rows - 1) / 2.0).y;
    std::tie(kx, ky) = metres_per_unit(*crs, centre_y);
    georef.crs = export_wkt(*crs);
    georef.crs_name = short_name(*crs);
  }
  georef.world_from_post = Affine2{{kx * a.m[0], kx * a.m[1], 0, ky * a.m[3], ky * a.m[4], 0}};
}

Placement place(GDALDataset& dataset, const std::string& source_crs, const std::string& name) {
  const int cols = dataset.GetRasterXSize();
  const int rows = dataset.GetRasterYSize();
  Placement placement;
  Georef& georef = placement.georef;
  const auto affine = pixel_centres(dataset);
  if (!affine && !source_crs.empty()) {
    throw Error(ErrorCode::InvalidInput,
                fmt::format("{}: does not say where its posts lie, in no CRS: leave out "
                            "--source-crs, or place it (gdal_translate -a_ullr)",
                            name));
  }
  if (!affine) {
    georef = unit_georef();
    placement.located = false;
    georef.notes.emplace_back("The file does not say where its posts lie: 1 m apart was assumed.");
    return placement;
  }
  georef.crs_from_post = *affine;
  const OGRSpatialReference* own = dataset.GetSpatialRef();
  std::optional<OGRSpatialReference> crs;
  if (!source_crs.empty()) {
    crs = parse_crs(source_crs, name);
  } else if (own != nullptr && !own->IsEmpty()) {
    crs = *own;
    crs->SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    if (crs->IsCompound() != 0) crs->StripVertical();
  } else if (looks_geographic(dataset, *affine)) {
    crs = parse_crs("EPSG:4326", name);
    georef.notes.emplace_back(
        "The file names no CRS; its axes are taken as WGS 84 longitude and latitude.");
  } else {
    georef.notes.emplace_back("The file names no CRS: its spacing is taken as metres.");
  }
  if (crs && crs->IsGeographic() != 0 && std::string_view(dataset.GetDriverName()) == "netCDF") {
    mend_float_axes(georef.crs_from_post, cols, rows);
  }
  turn_north_up(placement, cols, rows);
  fill_world(georef, cols, rows, crs ? &*crs : nullptr);
  return placement;
}

}  // namespace arete::raster
