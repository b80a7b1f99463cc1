#pragma once

#include "arete/lod/engine.h"

namespace arete::lod::full {

/// Params: "patch" (posts a side or auto).
void preprocess(const store::Terrain&, store::Writers&, const BuildContext&, const Params&);
std::unique_ptr<Engine> open(const store::Terrain&, const Params&);

}  // namespace arete::lod::full
