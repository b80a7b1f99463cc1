#pragma once

#include <cstdint>
#include <functional>

#include "arete/core/view.h"
#include "arete/mesh/surface.h"
#include "arete/proof/pixel_histogram.h"
#include "arete/proof/reference.h"

namespace arete::proof {

/// Distances on the screen between the true and the drawn surface, at the posts that count and
/// whose true position is in the viewport beyond the near plane, hidden ones too. A post whose
/// drawn position falls before the near plane is infinitely wrong.
struct Residuals {
  PixelHistogram px;
  double max_angular_px = 0;  ///< alpha_ang delta / D [METHODS 1.3]
  std::uint64_t undrawn = 0;  ///< posts in the viewport that no triangle covers; not in `px`
  void merge(const Residuals& other);
};

/// Row by row over the tiles that the view may see; the result does not depend on `threads`.
Residuals measure_residuals(const mesh::Surface& surface, const Reference& reference,
                            const View& view, int threads);

/// A post and the surface there, metres.
struct PostResidual {
  Post post;
  double true_z, drawn_z;
};

/// Calls visit for every post that counts and is covered, seen or not, tile by tile.
void for_each_residual(const mesh::Surface& surface, const Reference& reference,
                       const std::function<void(const PostResidual&)>& visit);

}  // namespace arete::proof
