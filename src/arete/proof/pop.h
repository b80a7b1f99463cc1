#pragma once

#include "arete/core/draw_list.h"
#include "arete/core/screen_error.h"
#include "arete/mesh/surface.h"
#include "arete/proof/pixel_histogram.h"
#include "arete/proof/reference.h"

namespace arete::proof {

/// The surfaces drawn for two successive views.
struct FramePair {
  const View& view_before;
  const View& view_after;
  const mesh::Surface& before;
  const mesh::Surface& after;
};

/// Screen distances between the surface drawn before and the one drawn after, both seen by the
/// later camera, over the counted posts whose true position is in the viewport in both frames.
PixelHistogram measure_pops(const FramePair& pair, const Reference& reference, int threads);

/// Distance in metres from the eye to the nearest bounding box of a drawn batch, 0 inside one;
/// infinite when nothing is drawn.
double nearest_batch_m(const DrawList& list, const BlockSource& blocks,
                       const Affine2& world_from_post, glm::dvec3 eye);

/// The relative motion |dP| / D + |dalpha| / alpha that lod::Claims::pop_px is a multiple of.
double relative_motion(const View& before, const View& after, ErrorScale scale, double nearest_m);

/// |after - before| / the larger; 0 when both are 0, infinite when one is.
double relative_change(double before, double after);

/// pop_px as a share of the promise, claim_px (lod::Claims::pop_px) times the relative motion; 0
/// without a promise or without a pop.
double pop_share(double pop_px, double claim_px, double motion);

}  // namespace arete::proof
