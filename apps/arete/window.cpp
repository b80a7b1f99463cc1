#include "window.h"

#include <algorithm>
#include <cstdlib>

#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include "arete/core/error.h"

namespace arete::app {
namespace {

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

Window::Window(const std::string& title, FrameSize size) : window_(open_window(title, size)) {
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window_, this);
  glfwSetKeyCallback(window_, note_key);  // ImGui's own callback passes keys on to this one
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  ImGui::StyleColorsDark();
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

void Window::note_key(GLFWwindow* window, int key, int, int action, int) {
  // A press that is released before the next frame must not be lost.
  if (action == GLFW_PRESS) {
    static_cast<Window*>(glfwGetWindowUserPointer(window))->arrived_.push_back(key);
  }
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

void Window::begin() {
  arrived_.clear();
  glfwPollEvents();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  pressed_ = ImGui::GetIO().WantCaptureKeyboard ? std::vector<int>{} : arrived_;
}

glm::dvec2 Window::cursor() const {
  const ImGuiIO& io = ImGui::GetIO();
  return glm::dvec2(io.MousePos.x, io.MousePos.y) *
         glm::dvec2(io.DisplayFramebufferScale.x, io.DisplayFramebufferScale.y);
}

Input Window::input() const {
  const ImGuiIO& io = ImGui::GetIO();
  const auto key = [&](int code) {
    return !io.WantCaptureKeyboard && glfwGetKey(window_, code) == GLFW_PRESS ? 1 : 0;
  };
  Input input;
  input.seconds = static_cast<double>(io.DeltaTime);
  input.fly = {key(GLFW_KEY_D) - key(GLFW_KEY_A), key(GLFW_KEY_W) - key(GLFW_KEY_S),
               key(GLFW_KEY_E) - key(GLFW_KEY_Q), key(GLFW_KEY_LEFT_SHIFT) != 0};
  if (io.WantCaptureMouse || !ImGui::IsMousePosValid()) {
    return input;
  }
  input.cursor = cursor();
  input.moved = glm::dvec2(io.MouseDelta.x, io.MouseDelta.y) *
                glm::dvec2(io.DisplayFramebufferScale.x, io.DisplayFramebufferScale.y);
  input.left = io.MouseDown[ImGuiMouseButton_Left];
  input.middle = io.MouseDown[ImGuiMouseButton_Middle];
  input.right = io.MouseDown[ImGuiMouseButton_Right];
  input.wheel = static_cast<double>(io.MouseWheel);
  input.double_click = ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
  return input;
}

void Window::end(unsigned framebuffer, FrameSize size) {
  ImGui::Render();
  glBlitNamedFramebuffer(framebuffer, 0, 0, 0, size.width, size.height, 0, 0, size.width,
                         size.height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, size.width, size.height);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  glfwSwapBuffers(window_);
}

}  // namespace arete::app
