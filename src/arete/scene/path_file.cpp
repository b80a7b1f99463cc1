#include <cmath>
#include <fstream>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "arete/core/error.h"
#include "arete/scene/path.h"

namespace arete::scene {
namespace {

using nlohmann::json;
constexpr double kDegree = std::numbers::pi / 180;

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what) {
  throw Error(ErrorCode::InvalidInput,
              fmt::format("{}: {}: write {{\"keyframes\": [{{\"t\", \"eye\": [x, y, z], \"yaw\", "
                          "\"pitch\", \"fovy\"}}]}}",
                          file.string(), what));
}

class KeyframeReader {
 public:
  KeyframeReader(const std::filesystem::path& file, const json& keyframe, std::size_t index)
      : file_(file), keyframe_(keyframe), index_(index) {}

  double number(const char* name, double low, double high) const {
    const auto found = keyframe_.find(name);
    if (found == keyframe_.end()) fail(fmt::format("no \"{}\"", name));
    return checked(*found, name, low, high);
  }

  glm::dvec3 eye() const {
    const auto found = keyframe_.find("eye");
    if (found == keyframe_.end() || !found->is_array() || found->size() != 3) {
      fail("\"eye\" is not three numbers");
    }
    constexpr double kFar = 1e12;
    return {checked((*found)[0], "eye", -kFar, kFar), checked((*found)[1], "eye", -kFar, kFar),
            checked((*found)[2], "eye", -kFar, kFar)};
  }

  bool has(const char* name) const { return keyframe_.contains(name); }

  [[noreturn]] void fail(const std::string& what) const {
    refuse(file_, fmt::format("keyframe {}: {}", index_, what));
  }

 private:
  double checked(const json& value, const char* name, double low, double high) const {
    if (!value.is_number()) fail(fmt::format("\"{}\" is not a number", name));
    const auto v = value.get<double>();
    if (!(v >= low && v <= high)) fail(fmt::format("\"{}\" is not in {} to {}", name, low, high));
    return v;
  }

  const std::filesystem::path& file_;
  const json& keyframe_;
  std::size_t index_;
};

Keyframe keyframe_of(const KeyframeReader& in) {
  Keyframe k;
  k.t = in.number("t", -1e9, 1e9);
  k.eye = in.eye();
  k.yaw = in.number("yaw", -1e6, 1e6) * kDegree;
  k.pitch = in.number("pitch", -90, 90) * kDegree;
  if (in.has("fovy")) k.fovy = in.number("fovy", 0.01, 179) * kDegree;
  return k;
}

json parse(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::error_code ignored;
  if (!in || std::filesystem::is_directory(file, ignored)) {
    throw Error(ErrorCode::NotFound,
                fmt::format("{}: cannot be read: check the name of the path file", file.string()));
  }
  json document = json::parse(in, nullptr, false);
  if (document.is_discarded()) refuse(file, "not JSON");
  return document;
}

}  // namespace

Path read_path(const std::filesystem::path& file) {
  const json document = parse(file);
  const auto list = document.is_object() ? document.find("keyframes") : document.end();
  if (!document.is_object() || list == document.end() || !list->is_array() || list->empty()) {
    refuse(file, "no keyframes");
  }
  std::vector<Keyframe> keyframes;
  for (const json& item : *list) {
    const KeyframeReader reader(file, item, keyframes.size());
    if (!item.is_object()) reader.fail("not an object");
    const Keyframe k = keyframe_of(reader);
    if (!keyframes.empty() && !(k.t > keyframes.back().t)) reader.fail("\"t\" does not ascend");
    keyframes.push_back(k);
  }
  return Path(std::move(keyframes));
}

void write_path(const Path& path, const std::filesystem::path& file) {
  json list = json::array();
  for (const Keyframe& k : path.keyframes()) {
    list.push_back({{"t", k.t},
                    {"eye", {k.eye.x, k.eye.y, k.eye.z}},
                    {"yaw", k.yaw / kDegree},
                    {"pitch", k.pitch / kDegree},
                    {"fovy", k.fovy / kDegree}});
  }
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out << json{{"keyframes", list}}.dump(1) << '\n';
  out.close();
  if (!out) {
    throw Error(ErrorCode::Io, fmt::format("{}: cannot be written: check the folder and its space",
                                           file.string()));
  }
}

}  // namespace arete::scene
