#include "path_recorder.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "flags.h"

namespace arete::app {
namespace {

namespace fs = std::filesystem;

scene::Keyframe keyframe(double t, const Pose& pose) {
  return {t, pose.eye, pose.yaw, pose.pitch, pose.fovy};
}

}  // namespace

void PathRecorder::load(scene::Path path) {
  path_ = std::move(path);
  replaying_ = true;
  replayed_ = 0;
}

void PathRecorder::toggle_replay() {
  replaying_ = !replaying_;
  replayed_ = 0;
}

std::string PathRecorder::toggle_recording(const Pose& pose) {
  if (!recording_) {
    replaying_ = false;
    recorded_ = 0;
    recording_.emplace().push_back(keyframe(0, pose));
    return "recording a path: P ends it";
  }
  std::vector<scene::Keyframe> keyframes = *std::exchange(recording_, std::nullopt);
  if (recorded_ > keyframes.back().t) {
    keyframes.push_back(keyframe(recorded_, pose));
  }
  const fs::path file = free_name("path", ".json");
  scene::Path path(std::move(keyframes));
  scene::write_path(path, file);
  load(std::move(path));
  return fmt::format("saved {}, replaying it", file.string());
}

void PathRecorder::record(const Pose& pose, double seconds) {
  constexpr double kKeyframeSeconds = 0.25;
  if (!recording_) {
    return;
  }
  recorded_ += seconds;
  if (recorded_ - recording_->back().t >= kKeyframeSeconds) {
    recording_->push_back(keyframe(recorded_, pose));
  }
}

Pose PathRecorder::replay(double seconds) {
  replayed_ += seconds;
  replaying_ = replayed_ < path_->duration();
  return path_->at(std::min(replayed_, path_->duration()));
}

Pose PathRecorder::instant(int i, int n) const {
  return path_->at(app::instant(*path_, i, n));
}

fs::path free_name(const std::string& stem, const std::string& extension) {
  for (int i = 1;; ++i) {
    fs::path file = fmt::format("{}-{}{}", stem, i, extension);
    if (!fs::exists(file)) {
      return file;
    }
  }
}

}  // namespace arete::app
