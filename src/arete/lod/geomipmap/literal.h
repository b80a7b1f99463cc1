#pragma once

#include "arete/lod/engine.h"

namespace arete::lod::geomipmap {

/// The article to the letter [Wagner2003; METHODS 7.2-7.4]: uniform diagonals, bands for any level
/// difference, levels from projected max-error vertices. Params as open().
std::unique_ptr<Engine> open_literal(const store::Terrain&, const Params&);

}  // namespace arete::lod::geomipmap
