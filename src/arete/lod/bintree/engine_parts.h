#pragma once

#include "arete/lod/bintree/coarsening.h"
#include "arete/lod/bintree/record_pages.h"
#include "arete/lod/engine.h"

namespace arete::lod::bintree {

/// From the param `delta`; exact by default. Throws: Usage.
Delta delta_param(const Params& params);
/// From the params `delta`, `pages` and `prefetch`. Throws: Usage.
RecordPages::Options page_options(const Params& params);

/// What nu delta + r with bounding deltas promises, and nothing where `bounded` is No.
enum class Bounded { No, Yes };
Claims claims_of(const RefineOptions& options, Bounded bounded);

/// Fills in what a frame's stats say of the surface. The error in pixels is the tolerance kept,
/// which stats name, unless something is missing; infinite where nothing is promised.
void report(const Ground& ground, const Findings& found, Bounded bounded, RefineStats& stats);
/// Bound on |drawn - true| over the frame, metres.
float error_m(const Findings& found, Bounded bounded);

}  // namespace arete::lod::bintree
