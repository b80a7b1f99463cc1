#pragma once

#include <array>
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

/// A deterministic camera flight with smooth (C1) interpolation between keyframes: cubic Hermite,
/// non-uniform Catmull-Rom slopes, yaw by the shorter arc. Two equal neighbours stand still between
/// them. A path that ends where it began, looking the same way, is closed: smooth there too.
class Path {
 public:
  /// Requires: at least one keyframe, t strictly ascending.
  explicit Path(std::vector<Keyframe> keyframes);
  double duration() const;  ///< from the first keyframe to the last
  bool closed() const { return closed_; }
  /// Camera at t seconds after the first keyframe, clamped to [0, duration()].
  /// Cost: O(log keyframes).
  Pose at(double t) const;
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }

 private:
  std::vector<Keyframe> keyframes_;
  std::vector<std::array<double, 6>> values_, slopes_;  // eye, yaw (unwrapped), pitch, fovy
  bool closed_ = false;
};

/// What a path may know of the land.
struct Ground {
  int cols = 0, rows = 0;
  Affine2 world_from_post;
  double z_min = 0, z_max = 0;
  /// Height in metres at a fractional post, clamped to the grid; filled where there is no data.
  std::function<double(double col, double row)> height;
};

/// "flyover", "orbit", "descent" (DESIGN.md section 5) or a JSON file. The named ones stay at least
/// one post spacing above the ground. Throws: Usage, NotFound, InvalidInput.
Path make_path(const std::string& name_or_file, const Ground& ground);

/// {"keyframes": [{"t", "eye": [x, y, z], "yaw", "pitch", "fovy"}, ...]}: seconds, metres, degrees.
/// Throws: NotFound, InvalidInput naming the keyframe.
Path read_path(const std::filesystem::path& json);
/// Throws: Io.
void write_path(const Path& path, const std::filesystem::path& json);

}  // namespace arete::scene
