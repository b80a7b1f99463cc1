#pragma once

#include <chrono>
#include <ctime>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arete/render/renderer.h"

#include "background_open.h"
#include "controls.h"
#include "flags.h"
#include "flight_log.h"
#include "overlay.h"
#include "path_recorder.h"
#include "shown_terrain.h"
#include "window.h"

namespace arete::app {

struct ViewFlags {
  FlightFlags flight;  ///< path empty = stay where the user is
  std::string method = "geomipmap";
  std::filesystem::path screenshot;  ///< written after `flight.frames` frames, then quit
  std::filesystem::path trace;       ///< a FlightLog, or none
};

/// The interactive viewer.
class Viewer {
 public:
  explicit Viewer(const ViewFlags& flags);
  /// Shows frames until the window is closed or the screenshot is taken. Throws: what kept the
  /// terrain of the command line from being opened or built.
  void run();

 private:
  void open(const std::filesystem::path& terrain);
  void take_opened();
  void take_failure();
  void show(OpenedTerrain opened);
  void show_frame();
  void show_land();
  void draw_land();
  void resize(FrameSize size);
  void act_on_keys();
  void press(const KeyPress& press);
  void press_over_land(const KeyPress& press);
  void set_tolerance(float pixels);
  void change_method(const std::string& method);
  void take_budget();
  std::size_t memory_beside_picture() const;
  void change_memory();
  void next_method();
  void press_path_key(bool shift);
  void go_home();
  void move_camera();
  void look_under_cursor();
  void draw_panel();
  std::vector<Notice> notices() const;
  std::string place_text() const;
  void save_screenshot(const std::filesystem::path& file);
  void tell(const std::string& text, Mood mood = Mood::Note);
  void log_frame();
  double seconds_to_wait();
  double aspect() const;
  bool scripted() const { return !flags_.screenshot.empty(); }

  ViewFlags flags_;
  std::optional<FlightLog> log_;
  std::optional<OpenedTerrain> first_;  ///< until the window is there to show it
  Window window_;
  std::unique_ptr<BackgroundOpen> opening_;
  std::filesystem::path opening_file_;
  bool reopen_ = false;                  ///< the cache changed while something was being opened
  std::exception_ptr failure_;           ///< of the terrain of the command line
  std::unique_ptr<ShownTerrain> shown_;  ///< none before the first preview
  std::optional<Controls> controls_;     ///< with the first terrain
  std::unique_ptr<render::Frame> frame_;
  PathRecorder path_;
  View view_;
  render::Style style_;
  FrameTimes times_;
  Knobs knobs_;
  std::optional<lod::Budget> budget_;       ///< of memory; once there is a method
  std::optional<glm::dvec3> under_cursor_;  ///< world metres
  std::optional<glm::dvec2> looked_at_;     ///< cursor of under_cursor_
  Pose looked_from_, drawn_from_;
  double above_ground_ = 0;  ///< metres
  bool frozen_ = false, help_ = false;
  Notice notice_;
  std::chrono::steady_clock::time_point told_{}, shown_at_{};
  std::clock_t cpu_at_ = 0;  ///< of the whole process when the last frame was on the screen
  int frames_shown_ = 0, frames_at_rest_ = 0;
};

}  // namespace arete::app
