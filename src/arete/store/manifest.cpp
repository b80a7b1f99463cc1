#include "arete/store/manifest.h"

#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "arete/core/error.h"
#include "arete/store/format.h"
#include "arete/store/hash.h"

namespace arete::store {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kHashLine = ",\n  \"hash\": \"";

std::string hash_line(std::string_view body) {
  return fmt::format("{}{}\"\n}}\n", kHashLine, hash128(body).hex());
}

Json to_json(const Manifest& m) {
  Json segments = Json::array();
  for (const SegmentRecord& s : m.segments)
    segments.push_back({{"name", s.name}, {"id", s.id}, {"bytes", s.bytes}});
  Json json;
  json["format"] = "arete";
  json["format_version"] = m.format_version;
  json["id"] = m.id;
  json["cols"] = m.cols;
  json["rows"] = m.rows;
  json["world_from_post"] = m.georef.world_from_post.m;
  json["crs_from_post"] = m.georef.crs_from_post.m;
  json["crs"] = m.georef.crs;
  json["crs_name"] = m.georef.crs_name;
  json["notes"] = m.georef.notes;
  json["z_min"] = m.z_min;
  json["z_max"] = m.z_max;
  json["quantum_m"] = m.quantum_m;
  json["offset_m"] = m.offset_m;
  json["max_store_error_m"] = m.max_store_error_m;
  json["nodata_share"] = m.nodata_share;
  json["drawable_cells"] = m.drawable_cells;
  json["source"] = m.source;
  json["methods"] = m.methods;
  json["segments"] = segments;
  return json;
}

Manifest from_json(const Json& json) {
  Manifest m;
  m.format_version = json.at("format_version").get<int>();
  json.at("id").get_to(m.id);
  json.at("cols").get_to(m.cols);
  json.at("rows").get_to(m.rows);
  json.at("world_from_post").get_to(m.georef.world_from_post.m);
  json.at("crs_from_post").get_to(m.georef.crs_from_post.m);
  json.at("crs").get_to(m.georef.crs);
  json.at("crs_name").get_to(m.georef.crs_name);
  json.at("notes").get_to(m.georef.notes);
  json.at("z_min").get_to(m.z_min);
  json.at("z_max").get_to(m.z_max);
  json.at("quantum_m").get_to(m.quantum_m);
  json.at("offset_m").get_to(m.offset_m);
  json.at("max_store_error_m").get_to(m.max_store_error_m);
  json.at("nodata_share").get_to(m.nodata_share);
  json.at("drawable_cells").get_to(m.drawable_cells);
  json.at("source").get_to(m.source);
  json.at("methods").get_to(m.methods);
  for (const Json& s : json.at("segments"))
    m.segments.push_back({s.at("name").get<std::string>(), s.at("id").get<std::string>(),
                          s.at("bytes").get<std::uint64_t>()});
  return m;
}

bool is_sane(const Manifest& m) {
  const bool sized = m.cols >= 1 && m.rows >= 1 && m.cols <= kMaxSide && m.rows <= kMaxSide;
  const bool lattice = std::isfinite(m.quantum_m) && m.quantum_m > 0 && std::isfinite(m.offset_m);
  std::set<std::string_view> names;
  bool named = true;
  for (const SegmentRecord& s : m.segments)
    named = named && is_segment_name(s.name) && names.insert(s.name).second;
  return sized && lattice && named;
}

}  // namespace

std::string to_text(const Manifest& manifest) {
  // Names and notes come from files in any encoding; JSON is UTF-8.
  std::string body = to_json(manifest).dump(2, ' ', false, Json::error_handler_t::replace);
  body.erase(body.rfind("\n}"));
  return body + hash_line(body);
}

Manifest parse_manifest(std::string_view text, const std::string& file) {
  const std::size_t at = text.rfind(kHashLine);
  if (at == std::string_view::npos || text.substr(at) != hash_line(text.substr(0, at)))
    throw Error(ErrorCode::Corrupt, file + ": damaged or not a manifest: rebuild the store");
  try {
    const Json json = Json::parse(text);
    const int version = json.at("format_version").get<int>();
    if (version != kFormatVersion)
      throw Error(ErrorCode::Unsupported,
                  fmt::format("{}: format version {}, this build reads {}: use another arete", file,
                              version, kFormatVersion));
    Manifest manifest = from_json(json);
    if (is_sane(manifest)) return manifest;
  } catch (const nlohmann::json::exception&) {
    // Told below: a manifest with a good hash and bad fields was written by something else.
  }
  throw Error(ErrorCode::Corrupt, file + ": fields are missing or wrong: rebuild the store");
}

std::string manifest_id(const Manifest& m) {
  std::string text =
      fmt::format("{} {} {} {} {} {}\n", m.format_version, m.cols, m.rows,
                  fmt::join(m.georef.world_from_post.m, " "), m.quantum_m, m.offset_m);
  for (const SegmentRecord& s : m.segments) text += fmt::format("{} {}\n", s.name, s.id);
  return hash128(text).hex();
}

}  // namespace arete::store
