#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/core/georef.h"
#include "arete/core/raster_source.h"
#include "arete/core/view.h"

namespace arete::render {

/// Whose land it is: decides tint, sea and sky.
enum class Body {
  Earth,    ///< green valleys to snow, sea below 0 m, blue sky
  Mars,     ///< ochres, a dusty sky, no sea
  Airless,  ///< greys under a black sky: the Moon and its like
};

/// What every frame of a terrain shares. The sources must outlive the renderer; null = none.
struct Land {
  Affine2 world_from_post;
  int cols = 0, rows = 0;
  double z_min = 0, z_max = 0;  ///< metres, for the tint
  Body body = Body::Earth;
  const RasterSource* normals = nullptr;
  const RasterSource* validity = nullptr;
  const RasterSource* drape = nullptr;
};

enum class Shading {
  Land,  ///< hypsometric tint or drape, lit, with haze
  Key,   ///< kKeyLand before kKeyBackground, no light, no haze: what `verify` counts leaks with
};

inline constexpr std::array<std::uint8_t, 3> kKeyLand{255, 255, 255};
inline constexpr std::array<std::uint8_t, 3> kKeyBackground{255, 0, 255};

struct Style {
  Shading shading = Shading::Land;
  bool wireframe = false;  ///< triangle edges over the land; Land only
  bool mask = true;        ///< discard fragments without data
  bool morph = true;       ///< false: factors are taken as 0
  /// Direction towards the sun, world, any length; from the north-west, as maps are shaded.
  glm::dvec3 sun{-0.62, 0.48, 0.62};
  /// Tiles of each pyramid (normals, validity, drape) that a frame may read; what is missing is
  /// shown coarser. Without a limit every frame is complete and depends on the view alone.
  int texture_tiles = std::numeric_limits<int>::max();
};

/// Colour + reversed-Z float depth, width x height.
class Frame {
 public:
  Frame(int width, int height);
  ~Frame();
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;
  int width() const;
  int height() const;
  static std::uint64_t bytes(int width, int height);  ///< that such a frame takes on the GPU
  unsigned framebuffer() const;                       ///< GL name, for blitting to a window
  /// width*height*3 bytes, top row first.
  std::vector<std::uint8_t> read_rgb() const;
  /// width*height depths, top row first: 1 at the near plane, 0 = nothing drawn. Distance along the
  /// view axis = near_m / depth.
  std::vector<float> read_depth() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct DrawStats {
  std::uint64_t triangles = 0, draws = 0;  ///< handed to GL, a strip's degenerate ones too
  std::uint64_t bytes_uploaded = 0;        ///< vertices, indices, factors and draw records
  std::uint64_t gpu_bytes = 0;             ///< buffer for blocks, and textures
  std::uint64_t dropped_batches = 0;       ///< did not fit gpu_memory
  std::uint64_t texture_tiles = 0;         ///< read by this frame
};

/// Draws any DrawList. Requires: a current OpenGL 4.5 context for the whole life of the object.
class Renderer {
 public:
  /// gpu_memory: hard cap on the bytes of buffers and textures, those of Frames not counted.
  /// Throws: Limit, Unsupported.
  explicit Renderer(const Land& land, std::size_t gpu_memory = std::size_t{1} << 30U);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  void draw(const View& view, const DrawList& list, const BlockSource& blocks, const Style& style,
            Frame& frame);
  /// Of the latest draw.
  const DrawStats& stats() const;
  /// Bytes of vertices (and of indices made for the view) that a list of at most `batches` batches
  /// may name beside `index_bytes` of index blocks so that all is drawn; 0 when there is no room.
  std::uint64_t vertex_room(std::uint64_t index_bytes, std::uint64_t batches) const;
  /// Frees the blocks that were uploaded from the source. Blocks are known by source and key: call
  /// it before an engine dies that this renderer has drawn, for another may be made at its address.
  void forget(const BlockSource& blocks);

  /// Transform feedback of the vertex stage: for each vertex of each batch's vertex block, in
  /// order, the drawn position (plan offset from the vertex's own post in posts, z in metres), 3
  /// floats; NaN where a block did not fit. For tests: one GL call a batch.
  std::vector<float> vertex_stage(const View& view, const DrawList& list,
                                  const BlockSource& blocks);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace arete::render
