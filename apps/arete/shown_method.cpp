#include "shown_method.h"

namespace arete::app {

ShownMethod::ShownMethod(const TerrainFlags& flags, const std::string& method,
                         const store::Terrain& terrain, const render::Land& land,
                         std::size_t gpu_memory)
    : name_(method), engine_(open_method(flags, method, terrain)), renderer_(land, gpu_memory) {}

void ShownMethod::refine(const View& view, const lod::RefineOptions& options) {
  engine_->refine(view, options, list_);
  refined_ = true;
}

void ShownMethod::draw(const View& view, const render::Style& style, render::Frame& frame) {
  renderer_.draw(view, list_, *engine_, style, frame);
}

}  // namespace arete::app
