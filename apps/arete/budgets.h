#pragma once

#include <cstddef>
#include <string>

#include "arete/lod/engine.h"
#include "arete/render/renderer.h"
#include "arete/store/terrain.h"

#include "flags.h"

namespace arete::app {

/// What --triangles, --cache and, with a renderer, --gpu-memory leave the method `name` on a
/// terrain that was opened under the same flags. Throws: Limit, naming the flag and the least that
/// would do, when its coarsest surface does not fit; for --cache it opens the method a few times
/// more to know.
lod::Budget budget_of(const FlightFlags& flags, const std::string& name,
                      const store::Terrain& terrain, const lod::Engine& engine,
                      const render::Renderer* renderer);

/// Bytes of --gpu-memory that a renderer may take beside one picture of --size. Throws: Limit.
std::size_t renderer_memory(const FlightFlags& flags);

/// Memory that grows with the terrain: tables, decoded tiles and vertices. What --cache caps.
std::uint64_t terrain_bytes(const store::Terrain& terrain, const lod::Footprint& method,
                            const RefineStats& stats);

}  // namespace arete::app
