#pragma once

#include <memory>

#include "arete/render/renderer.h"
#include "arete/store/terrain.h"

namespace arete::app {

/// The pyramids that a renderer reads of a terrain; must outlive the renderer.
struct LandRasters {
  explicit LandRasters(const store::Terrain& terrain);
  render::Land land;

 private:
  std::unique_ptr<RasterSource> normals_, validity_, drape_;
};

/// A frame with holes is no frame: Throws Limit when batches did not fit the GPU memory.
void require_all_drawn(const render::Renderer& renderer);

}  // namespace arete::app
