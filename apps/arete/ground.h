#pragma once

#include "arete/scene/path.h"
#include "arete/store/terrain.h"

namespace arete::app {

/// Heights of the finest tiles, read as they are needed (Wait), or of the finest that are in
/// memory (Resident; the one tile of the coarsest level is then read). Lives as long as `terrain`.
scene::Ground ground_of(const store::Terrain& terrain, store::Fetch fetch);

}  // namespace arete::app
