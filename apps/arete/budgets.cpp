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

std::uint64_t vertices_in_memory(const FlightFlags& flags, const store::Terrain& terrain,
                                 const lod::Footprint& method) {
  const Bytes cache = flags.terrain.cache;
  const std::uint64_t tables = terrain.table_bytes() + method.table_bytes;
  const std::uint64_t left = cache.count - tile_bytes(cache);
  if (left < tables + method.least.vertex_bytes) {
    const std::uint64_t need = tables + method.least.vertex_bytes;
    refuse(flags, "--cache", cache.count,
           fmt::format("tables take {} bytes and the coarsest surface {}", tables,
                       method.least.vertex_bytes),
           need + need / 3 + 4);  // a quarter is for tiles
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

lod::Budget budget_of(const FlightFlags& flags, const store::Terrain& terrain,
                      const lod::Engine& engine, const render::Renderer* renderer) {
  const lod::Footprint method = engine.footprint();
  lod::Budget budget;
  budget.triangles = flags.triangles;
  budget.vertex_bytes = vertices_in_memory(flags, terrain, method);
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
