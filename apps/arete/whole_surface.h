#pragma once

#include <array>

#include "arete/core/heightfield.h"
#include "arete/lod/engine.h"
#include "arete/mesh/surface.h"
#include "arete/store/terrain.h"

namespace arete::app {

/// The method's surface of the whole terrain with a vertical error of at most `max_error_m` metres.
mesh::Surface whole_surface(lod::Engine& engine, const store::Manifest& manifest,
                            double max_error_m);

/// True when a drawable cell lies within the bounding box of the triangle's corners: the others
/// show land that has no data.
bool touches_drawable_cell(const std::array<Post, 3>& corners, const Heightfield& dem);

}  // namespace arete::app
