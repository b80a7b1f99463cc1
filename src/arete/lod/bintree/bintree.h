#pragma once

#include "arete/lod/engine.h"

namespace arete::lod::bintree {

/// Writes the records that both methods read: segment "bintree" or "bintree-incremental".
/// Params:
///   delta     exact (default: bounds the error) or incremental (the papers' measure: no bound)
/// Throws: Usage, Limit, Cancelled, as building does.
void preprocess(const store::Terrain&, store::Writers&, const BuildContext&, const Params&);

}  // namespace arete::lod::bintree
