#pragma once

#include "arete/lod/engine.h"

namespace arete::lod::bintree {

/// SOAR: top-down refinement of the whole bin-tree every frame, one triangle strip
/// [LindstromPascucci2002; METHODS 3.2]. Params:
///   delta     exact (default: the error is bounded) or incremental (the papers')
///   morph     true: geomorph between two thirds of the tolerance and all of it; default false
///   pages     record pages of 4 KiB in memory; default 65536
///   prefetch  on (default) or off: whether pages are read before a frame misses them
/// Throws: Usage, NotFound, Corrupt.
std::unique_ptr<Engine> open_soar(const store::Terrain& terrain, const Params& params);

}  // namespace arete::lod::bintree
