#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arete/render/renderer.h"

#include "controls.h"
#include "flags.h"
#include "land_rasters.h"
#include "overlay.h"
#include "shown_method.h"
#include "window.h"

namespace arete::app {

struct ViewFlags {
  FlightFlags flight;  ///< path empty = stay where the user is
  std::string method = "geomipmap";
  std::filesystem::path screenshot;  ///< written after `flight.frames` frames, then quit
};

/// The interactive viewer.
class Viewer {
 public:
  explicit Viewer(const ViewFlags& flags);
  /// Shows frames until the window is closed or the screenshot is taken.
  void run();

 private:
  void show_frame();
  void act_on_keys();
  void press(int key);
  void next_method();
  void toggle_recording();
  void move_camera();
  void follow_path(double seconds);
  void resize(FrameSize size);
  void draw_panels();
  std::optional<glm::dvec3> under_cursor() const;
  void save_screenshot(const std::filesystem::path& file);
  bool scripted() const { return !flags_.screenshot.empty(); }

  ViewFlags flags_;
  std::unique_ptr<store::Terrain> terrain_;
  scene::Ground ground_;
  Window window_;
  LandRasters rasters_;
  std::unique_ptr<ShownMethod> shown_;
  std::unique_ptr<render::Frame> frame_;
  Controls controls_;
  std::optional<scene::Path> path_;
  double path_seconds_ = 0;
  std::optional<std::vector<scene::Keyframe>> recording_;
  double recorded_seconds_ = 0;
  View view_;
  render::Style style_;
  FrameTimes times_;
  float tolerance_px_;
  bool frozen_ = false, help_ = false;
  std::string message_;
  int frames_shown_ = 0;
};

}  // namespace arete::app
