#pragma once

#include <string>
#include <vector>

#include "controls.h"
#include "quantities.h"

struct GLFWwindow;

namespace arete::app {

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
  /// Of the framebuffer, pixels; at least 1 x 1.
  FrameSize size() const;

  /// Starts a frame: takes what the user did since the last one.
  void begin();
  /// GLFW key codes pressed since the last frame, in order; none while the overlay has the
  /// keyboard.
  const std::vector<int>& pressed() const { return pressed_; }
  /// Nothing held while the overlay has the mouse or the keyboard.
  Input input() const;
  /// Pixels of the framebuffer, y down; outside of it when the mouse is.
  glm::dvec2 cursor() const;
  /// Copies the lower left part of a framebuffer of this size, draws the overlay over it, shows it.
  void end(unsigned framebuffer, FrameSize size);

 private:
  static void note_key(GLFWwindow* window, int key, int scancode, int action, int mods);
  GLFWwindow* window_ = nullptr;
  std::vector<int> arrived_, pressed_;
};

}  // namespace arete::app
