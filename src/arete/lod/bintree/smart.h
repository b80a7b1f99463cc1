#pragma once

#include "arete/lod/engine.h"

namespace arete::lod::bintree {

/// SMART: the triangles of SOAR, frame by frame, with each status kept as long as its live range
/// lasts [BaoPajarolaShafae2004; METHODS 8]. Coherent: the order of the triangles is of the flight,
/// not of the view. Params: those of soar without morph, and
///   tick      S_min, millionths of the post spacing; default 100. Decides cost, not triangles
///   ticks     exact (default), ceil or floor: how motion becomes ticks; literal: floor
///   visit     ended (default) or all: which vertices a frame looks at; literal: all
///   capacity  nodes of the bin-tree array, to begin with; default 65536
///   literal   true: eq. 10 and 12 and Figure 6 as printed, which miss changes; default false
/// Throws: Usage, NotFound, Corrupt.
std::unique_ptr<Engine> open_smart(const store::Terrain& terrain, const Params& params);

}  // namespace arete::lod::bintree
