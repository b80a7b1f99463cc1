#pragma once

#include <memory>
#include <string>

namespace arete::render {

/// An OpenGL 4.5 core context without a window, current on the thread that made it: EGL device
/// platform (hardware before software), then surfaceless, then the default display.
class HeadlessContext {
 public:
  /// Throws: Unsupported, saying what was tried.
  HeadlessContext();
  ~HeadlessContext();
  HeadlessContext(const HeadlessContext&) = delete;
  HeadlessContext& operator=(const HeadlessContext&) = delete;
  const std::string& renderer() const;  ///< GL_RENDERER
  bool software() const;                ///< llvmpipe and its like

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace arete::render
