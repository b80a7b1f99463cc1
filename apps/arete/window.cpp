#include "window.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include "arete/core/error.h"

#include "overlay.h"

namespace arete::app {
namespace {

constexpr double kLongestStep = 0.1;  // seconds: a hiccup must not throw the camera far

bool has_display() {
  const auto set = [](const char* name) {
    const char* const value = std::getenv(name);
    return value != nullptr && *value != '\0';
  };
  return set("DISPLAY") || set("WAYLAND_DISPLAY");
}

std::string glfw_reason() {
  const char* reason = nullptr;
  glfwGetError(&reason);
  return reason != nullptr ? reason : "unknown reason";
}

GLFWwindow* open_window(const std::string& title, FrameSize size) {
  if (!has_display() || glfwInit() == GLFW_FALSE) {
    throw Error(ErrorCode::Unsupported,
                fmt::format("view: no display ({}): use 'arete render' to draw without one",
                            has_display() ? glfw_reason() : "DISPLAY is not set"));
  }
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  GLFWwindow* const window =
      glfwCreateWindow(size.width, size.height, title.c_str(), nullptr, nullptr);
  if (window == nullptr) {
    const std::string reason = glfw_reason();
    glfwTerminate();
    throw Error(ErrorCode::Unsupported,
                fmt::format("view: no OpenGL 4.5 window ({}): use 'arete render'", reason));
  }
  return window;
}

}  // namespace

// A press that is over before the next frame must not be lost: all is noted as it comes.
struct Window::Events {
  static Window& of(GLFWwindow* window) {
    auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(window));
    self.touched_ = true;
    return self;
  }

  static void key(GLFWwindow* window, int key, int scancode, int action, int mods) {
    Window& self = of(window);
    if (action != GLFW_PRESS) {
      return;
    }
    const char* const label = glfwGetKeyName(key, scancode);
    if (label != nullptr && std::isalnum(static_cast<unsigned char>(label[0])) != 0 &&
        label[1] == 0 && key < GLFW_KEY_ESCAPE) {
      key = std::toupper(static_cast<unsigned char>(label[0]));  // GLFW's codes are ASCII here
    }
    self.arrived_.push_back({key, (mods & GLFW_MOD_SHIFT) != 0});
  }

  static void button(GLFWwindow* window, int button, int action, int) {
    constexpr double kSeconds = 0.4, kPixels = 6;
    Window& self = of(window);
    if (action != GLFW_PRESS) {
      return;
    }
    // Not glfwGetCursorPos: that is where the mouse is by now.
    const glm::dvec2 at = self.mouse_;
    self.pressed_at_ = at;
    if (button != GLFW_MOUSE_BUTTON_LEFT) {
      return;
    }
    const double now = glfwGetTime();
    self.double_click_ = now - self.last_click_ < kSeconds && self.last_click_ >= 0 &&
                         glm::length(at - self.clicked_at_) < kPixels;
    self.last_click_ = self.double_click_ ? -1 : now;
    self.clicked_at_ = at;
  }

  static void drop(GLFWwindow* window, int count, const char** files) {
    of(window).dropped_.assign(files, files + count);
  }

  static void moved(GLFWwindow* window, double x, double y) { of(window).mouse_ = {x, y}; }
  static void scrolled(GLFWwindow* window, double, double) { of(window); }
  static void size(GLFWwindow* window, int, int) { of(window); }
  static void refresh(GLFWwindow* window) { of(window); }
};

Window::Window(const std::string& title, FrameSize size) : window_(open_window(title, size)) {
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window_, this);
  // ImGui's own callbacks pass keys and buttons on to these.
  glfwGetCursorPos(window_, &mouse_.x, &mouse_.y);
  glfwSetKeyCallback(window_, Events::key);
  glfwSetMouseButtonCallback(window_, Events::button);
  glfwSetScrollCallback(window_, Events::scrolled);
  glfwSetCursorPosCallback(window_, Events::moved);
  glfwSetFramebufferSizeCallback(window_, Events::size);
  glfwSetWindowRefreshCallback(window_, Events::refresh);
  glfwSetDropCallback(window_, Events::drop);
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  style_overlay();
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL3_Init("#version 450");
}

Window::~Window() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

bool Window::closed() const {
  return glfwWindowShouldClose(window_) != GLFW_FALSE;
}

void Window::close() {
  glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

FrameSize Window::size() const {
  FrameSize size;
  glfwGetFramebufferSize(window_, &size.width, &size.height);
  return {std::max(size.width, 1), std::max(size.height, 1)};
}

void Window::set_title(const std::string& title) {
  glfwSetWindowTitle(window_, title.c_str());
}

void Window::begin(double wait_seconds) {
  arrived_.clear();
  dropped_.clear();
  pressed_at_.reset();
  double_click_ = touched_ = false;
  if (wait_seconds > 0) {
    glfwWaitEventsTimeout(wait_seconds);
  } else {
    glfwPollEvents();
  }
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  pressed_ = ImGui::GetIO().WantCaptureKeyboard ? std::vector<KeyPress>{} : arrived_;
}

std::optional<glm::dvec2> Window::cursor() const {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantCaptureMouse || !ImGui::IsMousePosValid()) {
    return std::nullopt;
  }
  return glm::dvec2(io.MousePos.x, io.MousePos.y) * scale();
}

glm::dvec2 Window::scale() const {
  const ImVec2 scale = ImGui::GetIO().DisplayFramebufferScale;
  return {scale.x, scale.y};
}

Input Window::input() const {
  const ImGuiIO& io = ImGui::GetIO();
  const auto key = [&](int code) {
    return !io.WantCaptureKeyboard && glfwGetKey(window_, code) == GLFW_PRESS ? 1 : 0;
  };
  Input input;
  input.seconds = std::min(static_cast<double>(io.DeltaTime), kLongestStep);
  input.fly = {key(GLFW_KEY_D) - key(GLFW_KEY_A), key(GLFW_KEY_W) - key(GLFW_KEY_S),
               key(GLFW_KEY_E) - key(GLFW_KEY_Q),
               key(GLFW_KEY_LEFT_SHIFT) + key(GLFW_KEY_RIGHT_SHIFT) != 0};
  const auto at = cursor();
  if (!at) {
    return input;
  }
  input.cursor = *at;
  input.moved = glm::dvec2(io.MouseDelta.x, io.MouseDelta.y) * scale();
  input.left = io.MouseDown[ImGuiMouseButton_Left];
  input.middle = io.MouseDown[ImGuiMouseButton_Middle];
  input.right = io.MouseDown[ImGuiMouseButton_Right];
  if (pressed_at_) {
    input.pressed_at = *pressed_at_ * scale();
  }
  input.wheel = static_cast<double>(io.MouseWheel);
  input.double_click = double_click_;
  return input;
}

void Window::end(unsigned framebuffer, FrameSize size) {
  ImGui::Render();
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, size.width, size.height);
  if (framebuffer == 0) {
    glClearColor(0.06F, 0.07F, 0.09F, 1);
    glClear(GL_COLOR_BUFFER_BIT);
  } else {
    glBlitNamedFramebuffer(framebuffer, 0, 0, 0, size.width, size.height, 0, 0, size.width,
                           size.height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  }
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  glfwSwapBuffers(window_);
}

}  // namespace arete::app
