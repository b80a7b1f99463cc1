#pragma once

#include "arete/lod/engine.h"

namespace arete::lod::deboer {

/// Geometrical mipmapping as first published [deBoer2000; METHODS 3.5]. Params:
///   patch      posts a side of a block: 9, 17 (the paper's), 33, 65 or auto
///   topology   strip or list
///   trilinear  true: morph each block towards its next level
void preprocess(const store::Terrain&, store::Writers&, const BuildContext&, const Params&);
std::unique_ptr<Engine> open(const store::Terrain&, const Params&);

}  // namespace arete::lod::deboer
