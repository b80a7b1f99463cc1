#include "arete/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/render/batches.h"
#include "arete/render/block_arena.h"
#include "arete/render/clipmap.h"
#include "arete/render/frame_block.h"
#include "arete/render/gl_object.h"
#include "arete/render/programs.h"
#include "arete/render/tint.h"

namespace arete::render {
namespace {

constexpr int kGrainPosts = 48;  // posts a period of the grain
constexpr std::size_t kSmallestMemory = std::size_t{256} << 10U;

// GL state that a draw needs; put back to what other code in a window's context expects.
class DrawState {
 public:
  explicit DrawState(const Frame& frame) {
    glBindFramebuffer(GL_FRAMEBUFFER, frame.framebuffer());
    glViewport(0, 0, frame.width(), frame.height());
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_STENCIL_TEST);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_GREATER);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  }
  ~DrawState() {
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glDepthFunc(GL_LESS);
    glDisable(GL_DEPTH_TEST);
    glBindVertexArray(0);
    glUseProgram(0);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
  }
  DrawState(const DrawState&) = delete;
  DrawState& operator=(const DrawState&) = delete;
};

// Vertices only. GL wants a complete framebuffer even when nothing is rasterised.
class CaptureState {
 public:
  explicit CaptureState(const GlProgram& program) {
    glNamedFramebufferParameteri(framebuffer_.get(), GL_FRAMEBUFFER_DEFAULT_WIDTH, 1);
    glNamedFramebufferParameteri(framebuffer_.get(), GL_FRAMEBUFFER_DEFAULT_HEIGHT, 1);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
    glEnable(GL_RASTERIZER_DISCARD);
    glUseProgram(program.get());
  }
  ~CaptureState() {
    glDisable(GL_RASTERIZER_DISCARD);
    glBindVertexArray(0);
    glUseProgram(0);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
  }
  CaptureState(const CaptureState&) = delete;
  CaptureState& operator=(const CaptureState&) = delete;

 private:
  GlFramebuffer framebuffer_ = make_framebuffer();
};

GlVertexArray make_vertex_format() {
  GlVertexArray vao = make_vertex_array();
  const GLuint v = vao.get();
  for (GLuint attribute = 0; attribute < 4; ++attribute) {
    glEnableVertexArrayAttrib(v, attribute);
    glVertexArrayAttribBinding(v, attribute, 0);
  }
  glVertexArrayAttribIFormat(v, 0, 2, GL_INT, offsetof(Vertex, post));
  glVertexArrayAttribFormat(v, 1, 4, GL_FLOAT, GL_FALSE, offsetof(Vertex, z));
  glVertexArrayAttribIFormat(v, 2, 2, GL_SHORT, offsetof(Vertex, dcol));
  glVertexArrayAttribIFormat(v, 3, 4, GL_UNSIGNED_BYTE, offsetof(Vertex, slot));
  return vao;
}

// The post nearest to the eye, kept where differences to any post fit 32 bits.
glm::ivec2 nearest_post(glm::dvec2 p) {
  constexpr double kFar = 1 << 29;
  return {static_cast<int>(std::lround(std::clamp(p.x, -kFar, kFar))),
          static_cast<int>(std::lround(std::clamp(p.y, -kFar, kFar)))};
}

double side_length(const Land& land) {
  const double cells =
      std::max(1.0, std::max(land.cols - 1, 1) * double(std::max(land.rows - 1, 1)));
  return std::sqrt(std::abs(land.world_from_post.determinant()) * cells);
}

double spacing(const Land& land) {
  return std::sqrt(std::abs(land.world_from_post.determinant()));
}

}  // namespace

struct Renderer::Impl {
  Land land;
  Programs programs;
  Tint tint;
  GlTexture grain = make_grain();
  std::array<std::optional<Clipmap>, 3> clipmaps;  // normals, validity, drape
  BlockArena arena;
  Batches batches;
  GlVertexArray land_vertices = make_vertex_format();
  GlVertexArray no_vertices = make_vertex_array();
  GlBuffer frame_buffer = make_buffer();
  FrameBlock frame{};
  DrawStats stats;

  Impl(const Land& l, std::size_t gpu_memory)
      : land(l),
        tint(make_tint(l.body, l.z_min, l.z_max)),
        arena(gpu_memory - kTintBytes - make_clipmaps(gpu_memory)) {
    glNamedBufferStorage(frame_buffer.get(), sizeof frame, nullptr, GL_DYNAMIC_STORAGE_BIT);
  }

  // Bytes taken. At most half of the memory goes to textures.
  std::size_t make_clipmaps(std::size_t gpu_memory) {
    const std::array<const RasterSource*, 3> sources{land.normals, land.validity, land.drape};
    const std::array<std::size_t, 3> share{gpu_memory / 5, gpu_memory / 10, gpu_memory / 5};
    std::size_t taken = 0;
    for (std::size_t i = 0; i < sources.size(); ++i) {
      if (sources[i] == nullptr) continue;
      clipmaps[i].emplace(*sources[i], share[i]);
      taken += clipmaps[i]->bytes();
      if (clipmaps[i]->texture() == 0) clipmaps[i].reset();
    }
    return taken;
  }

  void set_camera(const View& view) {
    const glm::dmat4 m = clip_from_camera(view);
    const Affine2& a = land.world_from_post;
    const glm::ivec2 eye_post = nearest_post(a.inverse({view.eye.x, view.eye.y}));
    const glm::dvec2 offset = a.apply(eye_post.x, eye_post.y) - glm::dvec2(view.eye);
    const auto z_high = static_cast<float>(view.eye.z);
    frame.clip_from_camera = m;
    frame.camera_from_clip = glm::inverse(m);
    frame.plan = glm::dvec4(a.m[0], a.m[1], a.m[3], a.m[4]);
    frame.eye_offset = glm::vec4(offset, z_high, view.eye.z - static_cast<double>(z_high));
    frame.eye_post = glm::ivec4(eye_post, 0, 0);
    // Modulo the grain's period, so that the coordinates stay small numbers.
    const glm::ivec2 phase = (eye_post % kGrainPosts + kGrainPosts) % kGrainPosts;
    frame.grain_origin = glm::dvec4(phase, 1.0 / kGrainPosts, 0);
  }

  void set_look(const View& view, const Style& style) {
    const double range = std::max(land.z_max - land.z_min, 1e-6);
    const double side = side_length(land);
    // Wide lands look flat from high above and need steeper shading there; near the ground slopes
    // are nearly what they are.
    const double overview = glm::smoothstep(0.01, 0.3, (view.eye.z - land.z_max) / side);
    const double from_above = std::clamp(0.08 * side / range, 1.0, 5.0);
    const double gain = glm::mix(std::min(from_above, 1.8), from_above, overview);
    const double length = glm::length(style.sun);
    const glm::dvec3 sun = length > 0 ? style.sun / length : glm::dvec3(0, 0, 1);
    frame.sun = glm::dvec4(sun, gain);
    frame.tint = glm::dvec4(land.z_min, 1 / range, tint.sea_level, spacing(land));
    const double thickness = std::max(1.5 * range, 0.1 * side);
    const double air = land.body == Body::Airless ? 0 : 0.9 / side;
    frame.haze = glm::dvec4(air, 1 / thickness, view.eye.z - land.z_min, 0);
    set_sky();
  }

  void set_sky() {
    frame.sky_zenith = {0.035F, 0.115F, 0.36F, 1};
    frame.sky_horizon = {0.40F, 0.53F, 0.68F, 0};
    if (land.body == Body::Mars) {
      frame.sky_zenith = {0.22F, 0.15F, 0.10F, 1};
      frame.sky_horizon = {0.56F, 0.42F, 0.30F, 0};
    } else if (land.body == Body::Airless) {
      frame.sky_zenith = frame.sky_horizon = glm::vec4(0.0006F, 0.0006F, 0.0009F, 0);
    }
  }

  // The finest level that a pixel can tell apart from this height.
  int finest_useful(const View& view) const {
    const double above = view.eye.z - land.z_max;
    const double texels = above / (spacing(land) * view.focal_px());
    return texels <= 1 ? 0 : static_cast<int>(std::log2(texels));
  }

  void set_clipmaps(const View& view, const Style& style) {
    const glm::dvec2 centre = land.world_from_post.inverse({view.eye.x, view.eye.y});
    frame.has = glm::ivec4(0, 0, 0, land.body == Body::Earth ? 0 : 1);
    stats.texture_tiles = 0;
    for (std::size_t i = 0; i < clipmaps.size(); ++i) {
      const bool wanted = i == 1 ? style.mask : style.shading == Shading::Land;
      if (!clipmaps[i] || !wanted) continue;
      stats.texture_tiles += static_cast<std::uint64_t>(
          clipmaps[i]->update(centre, finest_useful(view), style.texture_tiles));
      frame.has[static_cast<int>(i)] = 1;
      frame.clips[i] = clipmaps[i]->block(glm::ivec2(frame.eye_post));
      glBindTextureUnit(static_cast<GLuint>(i), clipmaps[i]->texture());
    }
    glBindTextureUnit(3, tint.texture.get());
    glBindTextureUnit(4, grain.get());
  }

  void send_frame() {
    glNamedBufferSubData(frame_buffer.get(), 0, sizeof frame, &frame);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, frame_buffer.get());
  }

  void bind_vertices() {
    glVertexArrayVertexBuffer(land_vertices.get(), 0, arena.buffer(), 0, sizeof(Vertex));
    glVertexArrayElementBuffer(land_vertices.get(), arena.buffer());
    glBindVertexArray(land_vertices.get());
  }

  void draw_sky() {
    glDepthFunc(GL_GEQUAL);  // only where nothing was drawn: the sky lies at depth 0
    glUseProgram(programs.sky().get());
    glBindVertexArray(no_vertices.get());
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }

  // Runs the vertex stage over the block of the one batch placed.
  void capture(std::span<float> drawn) {
    const GlBuffer captured = make_buffer();
    const auto bytes = static_cast<GLsizeiptr>(drawn.size_bytes());
    glNamedBufferStorage(captured.get(), bytes, nullptr, 0);
    bind_vertices();
    batches.bind_factors(arena);
    glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, captured.get());
    glBeginTransformFeedback(GL_POINTS);
    glDrawArrays(GL_POINTS, batches.first_vertex(), static_cast<GLsizei>(drawn.size() / 3));
    glEndTransformFeedback();
    glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
    glGetNamedBufferSubData(captured.get(), 0, bytes, drawn.data());
  }

  void count() {
    stats.triangles = batches.triangles();
    stats.draws = batches.count();
    stats.dropped_batches = batches.dropped();
    stats.bytes_uploaded = arena.bytes_uploaded();
    stats.gpu_bytes = arena.capacity() + kTintBytes;
    for (const auto& c : clipmaps) stats.gpu_bytes += c ? c->bytes() : 0;
  }
};

Renderer::Renderer(const Land& land, std::size_t gpu_memory) {
  if (epoxy_gl_version() < 45 || !epoxy_has_gl_extension("GL_ARB_shader_draw_parameters")) {
    throw Error(ErrorCode::Unsupported,
                fmt::format("OpenGL: version {}.{} is too old: 4.5 with draw parameters is needed, "
                            "update the graphics driver",
                            epoxy_gl_version() / 10, epoxy_gl_version() % 10));
  }
  if (gpu_memory < kSmallestMemory) {
    throw Error(ErrorCode::Limit, fmt::format("GPU memory: {} bytes are too few: allow at least {}",
                                              gpu_memory, kSmallestMemory));
  }
  impl_ = std::make_unique<Impl>(land, gpu_memory);
}

Renderer::~Renderer() = default;

const DrawStats& Renderer::stats() const {
  return impl_->stats;
}

std::uint64_t Renderer::vertex_room(std::uint64_t index_bytes, std::uint64_t batches) const {
  const std::uint64_t rest = index_bytes + Batches::overhead(batches);
  const std::uint64_t cap = impl_->arena.cap();
  return cap > rest ? cap - rest : 0;
}

void Renderer::forget(const BlockSource& blocks) {
  impl_->arena.forget(&blocks);
}

void Renderer::draw(const View& view, const DrawList& list, const BlockSource& blocks,
                    const Style& style, Frame& frame) {
  Impl& r = *impl_;
  const DrawState state(frame);
  const glm::vec3 background =
      glm::vec3(kKeyBackground[0], kKeyBackground[1], kKeyBackground[2]) / 255.0F;
  glClearColor(background.x, background.y, background.z, 1);
  glClearDepth(0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  r.set_camera(view);
  r.set_look(view, style);
  r.set_clipmaps(view, style);
  r.send_frame();
  r.batches.place(list, blocks, style.morph ? Morph::On : Morph::Off, r.arena);
  r.bind_vertices();
  glUseProgram(r.programs.land(style, r.frame.has.y != 0 ? Mask::On : Mask::Off).get());
  r.batches.draw(r.arena);
  if (style.shading == Shading::Land) r.draw_sky();
  r.count();
}

std::vector<float> Renderer::vertex_stage(const View& view, const DrawList& list,
                                          const BlockSource& blocks) {
  Impl& r = *impl_;
  r.set_camera(view);
  r.send_frame();
  const CaptureState state(r.programs.vertex_stage());
  std::vector<float> drawn;
  DrawList one;
  one.vertices = list.vertices;
  one.uploads = list.uploads;
  for (const DrawBatch& batch : list.batches) {
    const std::size_t n =
        batch.vertices == kOwnBlock ? list.vertices.size() : blocks.vertices(batch.vertices).size();
    const std::size_t first = drawn.size();
    drawn.resize(first + 3 * n, std::numeric_limits<float>::quiet_NaN());
    one.batches.assign(1, batch);
    one.batches.front().indices = kOwnBlock;  // points need none
    r.batches.place(one, blocks, Morph::On, r.arena);
    if (r.batches.count() > 0 && n > 0) r.capture(std::span(drawn).subspan(first));
  }
  return drawn;
}

}  // namespace arete::render
