#include "budgets.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::app {
namespace {

[[noreturn]] void refuse(const FlightFlags& flags, const char* flag, std::size_t given,
                         const std::string& why, std::uint64_t least) {
  throw Error(ErrorCode::Limit,
              fmt::format("{}: {} {}: {}: allow at least {}", flags.terrain.terrain.string(), flag,
                          given, why, least));
}

// The least --cache under which so much is left beside tiles.
std::uint64_t with_tiles(std::uint64_t bytes) {
  return bytes + (bytes - 1) / 3;
}

// Pages grow with the cache, so a method is asked anew for what it would take under what it needed
// before. Its need grows more slowly than the cache: this ends, and at the least that will do.
std::uint64_t least_cache(TerrainFlags flags, const std::string& method,
                          const store::Terrain& terrain) {
  while (true) {
    const lod::Footprint takes = open_method(flags, method, terrain)->footprint();
    const std::uint64_t least =
        with_tiles(terrain.table_bytes() + takes.table_bytes + takes.least.vertex_bytes);
    if (least <= flags.cache.count) return flags.cache.count;
    flags.cache.count = least;
  }
}

std::uint64_t vertices_in_memory(const FlightFlags& flags, const std::string& name,
                                 const store::Terrain& terrain, const lod::Footprint& method) {
  const Bytes cache = flags.terrain.cache;
  const std::uint64_t tables = terrain.table_bytes() + method.table_bytes;
  const std::uint64_t left = cache.count - tile_bytes(cache);
  if (left < tables + method.least.vertex_bytes) {
    refuse(flags, "--cache", cache.count,
           fmt::format("tables take {} bytes and the coarsest surface {}", tables,
                       method.least.vertex_bytes),
           least_cache(flags.terrain, name, terrain));
  }
  return left - tables;
}

std::uint64_t vertices_on_gpu(const FlightFlags& flags, const lod::Footprint& method,
                              const render::Renderer& renderer) {
  const std::uint64_t room = renderer.vertex_room(method.index_bytes, method.batches);
  if (room < method.least.vertex_bytes) {
    const std::uint64_t missing = method.least.vertex_bytes + method.index_bytes;
    refuse(flags, "--gpu-memory", flags.gpu_memory.count,
           fmt::format("textures and lists leave {} bytes for vertices, the coarsest surface takes "
                       "{}",
                       room, method.least.vertex_bytes),
           flags.gpu_memory.count + 2 * missing);  // textures take at most half
  }
  return room;
}

}  // namespace

lod::Budget budget_of(const FlightFlags& flags, const std::string& name,
                      const store::Terrain& terrain, const lod::Engine& engine,
                      const render::Renderer* renderer) {
  const lod::Footprint method = engine.footprint();
  lod::Budget budget;
  budget.triangles = flags.triangles;
  budget.vertex_bytes = vertices_in_memory(flags, name, terrain, method);
  if (renderer != nullptr) {
    budget.vertex_bytes = std::min(budget.vertex_bytes, vertices_on_gpu(flags, method, *renderer));
  }
  lod::require_room(method, budget, flags.terrain.terrain.string());
  return budget;
}

std::size_t renderer_memory(const FlightFlags& flags) {
  const std::uint64_t picture = render::Frame::bytes(flags.size.width, flags.size.height);
  if (flags.gpu_memory.count <= picture) {
    refuse(flags, "--gpu-memory", flags.gpu_memory.count,
           fmt::format("a picture of {}x{} takes {} bytes", flags.size.width, flags.size.height,
                       picture),
           2 * picture);
  }
  return flags.gpu_memory.count - picture;
}

std::uint64_t terrain_bytes(const store::Terrain& terrain, const lod::Footprint& method,
                            const RefineStats& stats) {
  return terrain.table_bytes() + terrain.cache_stats().resident_bytes + method.table_bytes +
         stats.resident_bytes;
}

}  // namespace arete::app
