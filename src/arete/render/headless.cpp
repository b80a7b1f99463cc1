#include "arete/render/headless.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::render {
namespace {

bool has_word(const char* list, std::string_view word) {
  return list != nullptr && std::string_view(list).find(word) != std::string_view::npos;
}

// 0 = GPU with CUDA, 1 = other hardware, 2 = software. Mesa's software device also lists a DRM node
// extension on some systems, so its own name is looked for first.
int rank_of(EGLDeviceEXT device) {
  const char* extensions = eglQueryDeviceStringEXT(device, EGL_EXTENSIONS);
  if (has_word(extensions, "EGL_MESA_device_software")) return 2;
  return has_word(extensions, "EGL_NV_device_cuda") ? 0 : 1;
}

std::vector<EGLDeviceEXT> devices_by_rank(const char* client_extensions) {
  if (!has_word(client_extensions, "EGL_EXT_platform_device")) return {};
  if (!has_word(client_extensions, "EGL_EXT_device_enumeration") &&
      !has_word(client_extensions, "EGL_EXT_device_base")) {
    return {};
  }
  std::array<EGLDeviceEXT, 32> found{};
  EGLint count = 0;
  if (eglQueryDevicesEXT(static_cast<EGLint>(found.size()), found.data(), &count) == EGL_FALSE) {
    return {};
  }
  std::vector<EGLDeviceEXT> devices(found.begin(), found.begin() + count);
  std::stable_sort(devices.begin(), devices.end(),
                   [](EGLDeviceEXT a, EGLDeviceEXT b) { return rank_of(a) < rank_of(b); });
  return devices;
}

std::vector<EGLDisplay> candidate_displays() {
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  std::vector<EGLDisplay> displays;
  for (EGLDeviceEXT device : devices_by_rank(client)) {
    displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr));
  }
  if (has_word(client, "EGL_MESA_platform_surfaceless")) {
    displays.push_back(
        eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  }
  displays.push_back(eglGetDisplay(EGL_DEFAULT_DISPLAY));
  return displays;
}

}  // namespace

struct HeadlessContext::Impl {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  EGLSurface surface = EGL_NO_SURFACE;
  std::string renderer;

  // The display stays initialised: it belongs to the whole process, where others may use it.
  ~Impl() { release(); }

  void release() {
    if (display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (surface != EGL_NO_SURFACE) eglDestroySurface(display, surface);
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    context = EGL_NO_CONTEXT;
    surface = EGL_NO_SURFACE;
  }

  void give_up() {
    release();
    if (display != EGL_NO_DISPLAY) eglTerminate(display);
    display = EGL_NO_DISPLAY;
  }

  // Some drivers refuse a context without a surface: a small pbuffer serves those.
  bool make_current(EGLConfig config) {
    if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_TRUE) return true;
    const std::array<EGLint, 5> size{EGL_WIDTH, 16, EGL_HEIGHT, 16, EGL_NONE};
    surface = eglCreatePbufferSurface(display, config, size.data());
    return surface != EGL_NO_SURFACE &&
           eglMakeCurrent(display, surface, surface, context) == EGL_TRUE;
  }

  // An empty answer is success; else the step that failed.
  std::string_view open(EGLDisplay candidate) {
    if (candidate == EGL_NO_DISPLAY) return "no display";
    if (eglInitialize(candidate, nullptr, nullptr) == EGL_FALSE) return "does not initialise";
    display = candidate;
    if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) return "has no desktop OpenGL";
    const std::array<EGLint, 5> wish{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                     EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (eglChooseConfig(display, wish.data(), &config, 1, &count) == EGL_FALSE || count == 0) {
      return "has no OpenGL configuration";
    }
    const std::array<EGLint, 7> version{EGL_CONTEXT_MAJOR_VERSION,
                                        4,
                                        EGL_CONTEXT_MINOR_VERSION,
                                        5,
                                        EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                        EGL_NONE};
    context = eglCreateContext(display, config, EGL_NO_CONTEXT, version.data());
    if (context == EGL_NO_CONTEXT) return "refuses an OpenGL 4.5 core context";
    return make_current(config) ? "" : "cannot make its context current";
  }
};

HeadlessContext::HeadlessContext() : impl_(std::make_unique<Impl>()) {
  std::string tried;
  for (EGLDisplay display : candidate_displays()) {
    const std::string_view failure = impl_->open(display);
    if (failure.empty()) {
      const GLubyte* name = glGetString(GL_RENDERER);
      impl_->renderer = name != nullptr ? reinterpret_cast<const char*>(name) : "unknown";
      return;
    }
    impl_->give_up();
    tried += fmt::format("{}{}", tried.empty() ? "" : ", ", failure);
  }
  throw Error(ErrorCode::Unsupported,
              fmt::format("OpenGL: no headless 4.5 context ({}): install Mesa (libegl1, "
                          "libgl1-mesa-dri) or a GPU driver with EGL",
                          tried));
}

HeadlessContext::~HeadlessContext() = default;

const std::string& HeadlessContext::renderer() const {
  return impl_->renderer;
}

bool HeadlessContext::software() const {
  static constexpr std::array<std::string_view, 5> kSoftware{"llvmpipe", "softpipe", "swrast",
                                                             "SwiftShader", "Microsoft Basic"};
  return std::any_of(kSoftware.begin(), kSoftware.end(), [this](std::string_view name) {
    return impl_->renderer.find(name) != std::string::npos;
  });
}

}  // namespace arete::render
