#include <optional>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/proof/leaks.h"
#include "arete/render/headless.h"
#include "arete/render/renderer.h"

namespace arete::proof {
struct GlPicture::Impl {
  Impl(const Heightfield& dem, std::size_t gpu_memory)
      : renderer({.world_from_post = dem.georef().world_from_post,
                  .cols = dem.cols(),
                  .rows = dem.rows()},
                 gpu_memory) {}

  render::HeadlessContext context;  // made before and dropped after what lives in it
  render::Renderer renderer;
  std::optional<render::Frame> frame;
};

GlPicture::GlPicture(const Heightfield& dem, std::size_t gpu_memory)
    : impl_(std::make_unique<Impl>(dem, gpu_memory)) {}
GlPicture::~GlPicture() = default;

std::uint64_t GlPicture::vertex_room(std::uint64_t index_bytes, std::uint64_t batches) const {
  return impl_->renderer.vertex_room(index_bytes, batches);
}

std::vector<float> GlPicture::depth(const View& view, const DrawList& list,
                                    const BlockSource& blocks) {
  std::optional<render::Frame>& frame = impl_->frame;
  if (!frame || frame->width() != view.viewport_width || frame->height() != view.viewport_height) {
    frame.emplace(view.viewport_width, view.viewport_height);
  }
  impl_->renderer.draw(view, list, blocks, {.shading = render::Shading::Key, .mask = false},
                       *frame);
  if (const std::uint64_t dropped = impl_->renderer.stats().dropped_batches; dropped > 0) {
    throw Error(ErrorCode::Limit,
                fmt::format("verify: {} batches of a frame do not fit the GPU memory: ask for a "
                            "coarser tolerance",
                            dropped));
  }
  return frame->read_depth();
}

}  // namespace arete::proof
