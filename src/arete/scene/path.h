#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "arete/core/georef.h"
#include "arete/core/view.h"

namespace arete::scene {

struct Keyframe {
  double t = 0;  ///< seconds
  glm::dvec3 eye{0};
  double yaw = 0, pitch = 0, fovy = 1.0471975511965976;  ///< radians (degrees in JSON)
};

/// A deterministic camera flight with smooth (C1) interpolation between keyframes.
class Path {
 public:
  /// Requires: at least one keyframe, t ascending.
  explicit Path(std::vector<Keyframe> keyframes);
  double duration() const;
  Pose at(double t) const;
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }

 private:
  std::vector<Keyframe> keyframes_;
};

/// What a path may know of the land.
struct Ground {
  int cols = 0, rows = 0;
  Affine2 world_from_post;
  double z_min = 0, z_max = 0;
  /// Height in metres at a fractional post, clamped to the grid; filled where there is no data.
  std::function<double(double col, double row)> height;
};

/// "flyover", "orbit", "descent" (DESIGN.md section 5) or a JSON file. Throws: kUsage, kNotFound,
/// kInvalidInput.
Path make_path(const std::string& name_or_file, const Ground& ground);

Path read_path(const std::filesystem::path& json);
void write_path(const Path& path, const std::filesystem::path& json);

}  // namespace arete::scene
