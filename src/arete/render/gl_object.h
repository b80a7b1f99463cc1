#pragma once

#include <utility>

#include <epoxy/gl.h>

namespace arete::render {

/// Owns one GL name. Requires: the context that made it is current when it dies.
template <void (*Delete)(GLuint)>
class GlName {
 public:
  GlName() = default;
  explicit GlName(GLuint name) : name_(name) {}
  ~GlName() { reset(); }
  GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlName& operator=(GlName&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  void reset() {
    if (name_ != 0) Delete(std::exchange(name_, 0));
  }
  GLuint get() const { return name_; }
  explicit operator bool() const { return name_ != 0; }

 private:
  GLuint name_ = 0;
};

inline void delete_buffer(GLuint n) {
  glDeleteBuffers(1, &n);
}
inline void delete_texture(GLuint n) {
  glDeleteTextures(1, &n);
}
inline void delete_vertex_array(GLuint n) {
  glDeleteVertexArrays(1, &n);
}
inline void delete_framebuffer(GLuint n) {
  glDeleteFramebuffers(1, &n);
}
inline void delete_program(GLuint n) {
  glDeleteProgram(n);
}
inline void delete_shader(GLuint n) {
  glDeleteShader(n);
}

using GlBuffer = GlName<delete_buffer>;
using GlTexture = GlName<delete_texture>;
using GlVertexArray = GlName<delete_vertex_array>;
using GlFramebuffer = GlName<delete_framebuffer>;
using GlProgram = GlName<delete_program>;
using GlShader = GlName<delete_shader>;

inline GlBuffer make_buffer() {
  GLuint n = 0;
  glCreateBuffers(1, &n);
  return GlBuffer(n);
}
inline GlTexture make_texture(GLenum target) {
  GLuint n = 0;
  glCreateTextures(target, 1, &n);
  return GlTexture(n);
}
inline GlVertexArray make_vertex_array() {
  GLuint n = 0;
  glCreateVertexArrays(1, &n);
  return GlVertexArray(n);
}
inline GlFramebuffer make_framebuffer() {
  GLuint n = 0;
  glCreateFramebuffers(1, &n);
  return GlFramebuffer(n);
}

}  // namespace arete::render
