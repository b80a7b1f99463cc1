#pragma once

#include "arete/lod/engine.h"

namespace arete::lod::geomipmap {

/// Wagner's geomorphing geomipmaps in exact form [Wagner2003; METHODS 7]. Params:
///   patch     posts a side: 9, 17 (the paper's), 33, 65, 129 or auto; at most 65 when literal
///   topology  list or strip (the paper's: one strip a patch, degenerate joins); strip when literal
///   literal   true: as the article has it, with what it cannot keep; needs segment "maxerror-N"
void preprocess(const store::Terrain&, store::Writers&, const BuildContext&, const Params&);
std::unique_ptr<Engine> open(const store::Terrain&, const Params&);

}  // namespace arete::lod::geomipmap
