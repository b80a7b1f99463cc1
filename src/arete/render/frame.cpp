#include <algorithm>
#include <cstddef>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/render/gl_object.h"
#include "arete/render/renderer.h"

namespace arete::render {
namespace {

// GL's rows run upwards, pictures' downwards.
template <typename T>
void flip_rows(std::vector<T>& picture, std::size_t row) {
  const auto stride = static_cast<std::ptrdiff_t>(row);
  auto top = picture.begin();
  auto bottom = picture.end() - stride;
  for (; top < bottom; top += stride, bottom -= stride) {
    std::swap_ranges(top, top + stride, bottom);
  }
}

}  // namespace

struct Frame::Impl {
  int width, height;
  GlTexture colour = make_texture(GL_TEXTURE_2D);
  GlTexture depth = make_texture(GL_TEXTURE_2D);
  GlFramebuffer framebuffer = make_framebuffer();

  template <typename T>
  std::vector<T> read(GLenum format, GLenum type, std::size_t channels) const {
    const std::size_t row = static_cast<std::size_t>(width) * channels;
    std::vector<T> picture(row * static_cast<std::size_t>(height));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer.get());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, format, type, picture.data());
    flip_rows(picture, row);
    return picture;
  }
};

Frame::Frame(int width, int height) : impl_(new Impl{width, height}) {
  GLint limit = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
  if (width < 1 || height < 1 || width > limit || height > limit) {
    throw Error(ErrorCode::Limit, fmt::format("{}x{}: no such picture size: use 1 to {} a side",
                                              width, height, limit));
  }
  glTextureStorage2D(impl_->colour.get(), 1, GL_RGBA8, width, height);
  glTextureStorage2D(impl_->depth.get(), 1, GL_DEPTH_COMPONENT32F, width, height);
  const GLuint fbo = impl_->framebuffer.get();
  glNamedFramebufferTexture(fbo, GL_COLOR_ATTACHMENT0, impl_->colour.get(), 0);
  glNamedFramebufferTexture(fbo, GL_DEPTH_ATTACHMENT, impl_->depth.get(), 0);
  if (glCheckNamedFramebufferStatus(fbo, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw Error(ErrorCode::Unsupported,
                "OpenGL: no RGBA8 + D32F framebuffer: update the graphics driver");
  }
}

Frame::~Frame() = default;

int Frame::width() const {
  return impl_->width;
}

int Frame::height() const {
  return impl_->height;
}

std::uint64_t Frame::bytes(int width, int height) {
  constexpr std::uint64_t kPixel = 4 + 4;  // RGBA8, D32F
  return kPixel * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
}

unsigned Frame::framebuffer() const {
  return impl_->framebuffer.get();
}

std::vector<std::uint8_t> Frame::read_rgb() const {
  return impl_->read<std::uint8_t>(GL_RGB, GL_UNSIGNED_BYTE, 3);
}

std::vector<float> Frame::read_depth() const {
  return impl_->read<float>(GL_DEPTH_COMPONENT, GL_FLOAT, 1);
}

}  // namespace arete::render
