#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "arete/core/georef.h"
#include "arete/core/view.h"
#include "arete/mesh/surface.h"

namespace arete::proof {

/// A picture of a surface: width x height pixels, row-major, top row first.
struct Picture {
  static constexpr std::uint32_t kNothing = 0xFFFFFFFFU;
  int width = 0, height = 0;
  std::vector<float> depth;             ///< reversed-Z: 1 at the near plane, 0 = nothing drawn
  std::vector<std::uint32_t> triangle;  ///< the nearest triangle's number, or Nothing
};

struct RasterOptions {
  glm::dvec2 sample_shift{0};  ///< pixels (x right, y down) from the pixel's centre to its sample
  int threads = 1;
};

/// Software rasteriser [METHODS S8]: top-left rule, corners snapped to 1/256 px, both sides drawn,
/// so that a conforming surface leaves no pixel inside its silhouette. The result does not depend
/// on `threads`.
Picture rasterise(const mesh::Surface& surface, const Affine2& world_from_post, const View& view,
                  const RasterOptions& options);

}  // namespace arete::proof
