#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/core/heightfield.h"
#include "arete/core/view.h"
#include "arete/mesh/surface.h"

namespace arete::proof {

/// Draws a list and gives its depths: width x height, top row first, reversed-Z, 0 = nothing drawn.
using DrawDepth =
    std::function<std::vector<float>(const View&, const DrawList&, const BlockSource&)>;

/// Pixels where `depth` shows nothing although the surface's triangles cover the pixel's centre and
/// its four corners (CPU rasteriser): leaks, not silhouettes. Requires: depths of the view's size.
std::uint64_t background_pixels(std::span<const float> depth, const mesh::Surface& surface,
                                const Affine2& world_from_post, const View& view, int threads);

/// The renderer's own picture without a window: mask off, one flat colour.
/// Thread contract: one thread, the one that made it.
class GlPicture {
 public:
  /// Throws: Unsupported when there is no OpenGL, saying what was tried.
  /// gpu_memory: as Renderer's. Throws also: Limit.
  explicit GlPicture(const Heightfield& dem, std::size_t gpu_memory = std::size_t{1} << 30U);
  ~GlPicture();
  GlPicture(const GlPicture&) = delete;
  GlPicture& operator=(const GlPicture&) = delete;
  /// As Renderer's.
  std::uint64_t vertex_room(std::uint64_t index_bytes, std::uint64_t batches) const;
  /// Throws: Limit when the list does not fit the renderer's memory.
  std::vector<float> depth(const View& view, const DrawList& list, const BlockSource& blocks);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace arete::proof
