#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "controls.h"
#include "quantities.h"

struct GLFWwindow;

namespace arete::app {

/// A key that went down: a GLFW key code, for letters and digits by its label on the keyboard in
/// use.
struct KeyPress {
  int key = 0;
  bool shift = false;
};

/// A window with an OpenGL 4.5 core context, current on this thread, and a Dear ImGui frame.
/// One at a time.
class Window {
 public:
  /// Throws: Unsupported, naming `render`, when there is no display or no OpenGL 4.5.
  Window(const std::string& title, FrameSize size);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool closed() const;
  void close();
  void set_title(const std::string& title);
  /// Of the framebuffer, pixels; at least 1 x 1.
  FrameSize size() const;

  /// Starts a frame: takes what the user did since the last one, waiting up to so many seconds for
  /// it to be something.
  void begin(double wait_seconds);
  /// Something happened: a key, the mouse, a drop, another size.
  bool touched() const { return touched_; }
  /// Keys pressed since the last frame, in order; none while the overlay has the keyboard.
  const std::vector<KeyPress>& pressed() const { return pressed_; }
  /// Files dropped since the last frame.
  const std::vector<std::filesystem::path>& dropped() const { return dropped_; }
  /// Nothing held while the overlay has the mouse or the keyboard.
  Input input() const;
  /// Pixels of the framebuffer, y down; nothing when the mouse is outside or over the overlay.
  std::optional<glm::dvec2> cursor() const;
  /// Copies the lower left part of a framebuffer of this size, draws the overlay over it, shows it.
  /// Framebuffer 0: a plain dark ground instead.
  void end(unsigned framebuffer, FrameSize size);

 private:
  struct Events;             // GLFW's callbacks
  glm::dvec2 scale() const;  ///< framebuffer pixels per window coordinate
  GLFWwindow* window_ = nullptr;
  std::vector<KeyPress> arrived_, pressed_;
  std::vector<std::filesystem::path> dropped_;
  glm::dvec2 mouse_{0};                   ///< window coordinates, as events told
  std::optional<glm::dvec2> pressed_at_;  ///< window coordinates
  double last_click_ = -1;                ///< seconds
  glm::dvec2 clicked_at_{0};
  bool double_click_ = false, touched_ = false;
};

}  // namespace arete::app
