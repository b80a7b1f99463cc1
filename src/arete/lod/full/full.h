#pragma once

#include "arete/lod/engine.h"

namespace arete::lod::full {

/// Patch size and vertex budget; Params "patch" (posts a side or auto) and "blocks" (MiB).
void preprocess(const store::Terrain&, store::Writers&, const BuildContext&, const Params&);
std::unique_ptr<Engine> open(const store::Terrain&, const Params&);

}  // namespace arete::lod::full
