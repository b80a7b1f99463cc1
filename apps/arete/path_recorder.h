#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "arete/scene/path.h"

namespace arete::app {

/// Replays the path that was given or recorded last, and records new ones.
class PathRecorder {
 public:
  /// Begins to replay it.
  void load(scene::Path path);
  bool holds_path() const { return path_.has_value(); }
  bool replaying() const { return replaying_; }
  bool recording() const { return recording_.has_value(); }

  /// Replays from the beginning, or stops replaying. Requires: holds_path().
  void toggle_replay();
  /// Begins a recording, or writes it to the first free path-N.json of the working directory and
  /// replays it. Returns what to tell the user. Throws: Io; the recording is lost then.
  std::string toggle_recording(const Pose& pose);
  /// A recording takes the camera of this frame.
  void record(const Pose& pose, double seconds);
  /// The camera so many seconds later, as it replays; the path ends by itself.
  Pose replay(double seconds);
  /// The camera at the i-th of n instants.
  Pose instant(int i, int n) const;
  void stop() { replaying_ = false; }

 private:
  std::optional<scene::Path> path_;
  bool replaying_ = false;
  double replayed_ = 0, recorded_ = 0;  ///< seconds
  std::optional<std::vector<scene::Keyframe>> recording_;
};

/// NAME-1.EXT, NAME-2.EXT, ...: the first that is not there yet.
std::filesystem::path free_name(const std::string& stem, const std::string& extension);

}  // namespace arete::app
