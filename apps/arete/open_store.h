#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arete/store/terrain.h"

#include "method_flags.h"
#include "progress.h"
#include "quantities.h"
#include "recipe.h"

namespace arete::app {

/// How a store's files are read.
enum class Io { Read, Map };

/// A terrain on the command line: a store, or a DEM to build one from.
struct TerrainFlags {
  std::filesystem::path terrain;
  MethodFlags method_flags;
  Bytes cache{std::size_t{512} << 20U};  ///< for tables, tiles and vertices together
  bool prefetch = true;
  Io io = Io::Read;
  Talk talk = Talk::Normal;
};

/// The store itself. A DEM is built, for these methods, into $XDG_CACHE_HOME/arete or
/// ~/.cache/arete under a name that is keyed by path, size, mtime and options; stores that were
/// not used for longest go when the directory holds more than 20 GB.
/// Throws: as build_store; NotFound.
std::filesystem::path store_of(const TerrainFlags& flags, const std::vector<std::string>& methods,
                               const BuildProgress& progress = {});
/// The same when nothing has to be built for it. Throws: NotFound.
std::optional<std::filesystem::path> ready_store(const TerrainFlags& flags,
                                                 const std::vector<std::string>& methods);

/// What of --cache holds decoded tiles, and as much again the pages of methods that have their own;
/// the rest is for tables and vertices.
std::size_t tile_bytes(Bytes cache);

/// Opens a store with the cache budget.
std::unique_ptr<store::Terrain> open_store(const TerrainFlags& flags,
                                           const std::filesystem::path& store);
/// Opens store_of(...) likewise.
std::unique_ptr<store::Terrain> open_terrain(const TerrainFlags& flags,
                                             const std::vector<std::string>& methods);

/// Says on stderr, quiet or not, when blocks that were read so far are damaged: what is missing was
/// drawn coarser.
void tell_of_damage(const store::Terrain& terrain, const TerrainFlags& flags);

/// The method opened on the terrain with its settings.
std::unique_ptr<lod::Engine> open_method(const TerrainFlags& flags, const std::string& method,
                                         const store::Terrain& terrain);

std::filesystem::path cache_directory();

/// Removes the stores of `directory` that were not used for longest until those left hold at most
/// `limit` bytes; `keep` stays.
void drop_oldest(const std::filesystem::path& directory, const std::filesystem::path& keep,
                 std::uintmax_t limit);

}  // namespace arete::app
