#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>

#include "arete/core/view.h"

namespace arete::app {

/// A flight as CSV, a line a frame, written as it happens.
class FlightLog {
 public:
  struct Line {
    double seconds = 0;        ///< since the program began
    double frame_ms = 0;       ///< since the frame before was on the screen
    double cpu_ms = 0;         ///< that the whole process computed in that time
    std::string_view terrain;  ///< "store", or "preview" while the store is being built
    std::string_view method, mode;
    Pose pose;
    double above_ground = 0;           ///< metres from the ground below to the eye
    glm::dvec2 cursor{0};              ///< pixels, y down
    std::optional<glm::dvec3> ground;  ///< world metres, under the cursor; empty = sky
    int width = 0, height = 0;         ///< pixels
    unsigned long long triangles = 0, late_blocks = 0;
    double achieved_error_px = 0;
  };

  /// Throws: Io.
  explicit FlightLog(const std::filesystem::path& file);
  /// Throws: Io.
  void add(const Line& line);

 private:
  void require_written();
  std::filesystem::path file_;
  std::ofstream out_;
  long long frame_ = 0;
};

}  // namespace arete::app
