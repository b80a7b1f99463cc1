#include "open_store.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/store/part_directory.h"

#include "recipe.h"

namespace arete::app {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kCacheLimit = std::uintmax_t{20'000'000'000};

bool is_store(const fs::path& path) {
  return fs::is_directory(path) || path.extension() == ".arete" || path.filename().empty() ||
         store::retired_store(path);
}

std::uintmax_t bytes_under(const fs::path& directory) {
  std::uintmax_t bytes = 0;
  std::error_code ignored;
  for (const auto& entry : fs::recursive_directory_iterator(directory, ignored)) {
    if (entry.is_regular_file(ignored)) {
      bytes += entry.file_size(ignored);
    }
  }
  return bytes;
}

// What the cache holds of a terrain. One that cannot be opened is made anew: nobody else owns it.
enum class Cached { Nothing, Damaged, FewerMethods, Whole };

Cached look_up(const fs::path& store, const std::vector<std::string>& methods) {
  if (!fs::exists(store)) {
    return Cached::Nothing;
  }
  store::OpenOptions options;
  options.prefetch = false;
  try {
    const auto terrain = store::Terrain::open(store, options);
    const std::vector<std::string>& held = terrain->manifest().methods;
    const bool whole = std::ranges::all_of(
        methods, [&](const std::string& method) { return std::ranges::count(held, method) != 0; });
    return whole ? Cached::Whole : Cached::FewerMethods;
  } catch (const Error&) {
    return Cached::Damaged;
  }
}

Recipe recipe_of(const TerrainFlags& flags, const std::vector<std::string>& methods) {
  Recipe recipe;
  recipe.dems = {flags.terrain};
  recipe.methods = methods;
  recipe.method_flags = flags.method_flags;
  return recipe;
}

fs::path cached_path(const TerrainFlags& flags, const Recipe& recipe) {
  // The hash only has to be the same for the same compiler: another one builds anew.
  std::string text = source_key(recipe) + "|" + flags.method_flags.patch;
  for (const std::string& setting : flags.method_flags.settings) {
    text += "|" + setting;
  }
  const std::size_t key = std::hash<std::string>{}(text);
  return cache_directory() / fmt::format("{}-{:016x}.arete", flags.terrain.stem().string(), key);
}

void note_use(const fs::path& store) {
  std::error_code ignored;
  fs::last_write_time(store, fs::file_time_type::clock::now(), ignored);
}

fs::path cached_store(const TerrainFlags& flags, const std::vector<std::string>& methods,
                      const BuildProgress& progress) {
  Recipe recipe = recipe_of(flags, methods);
  recipe.progress = progress;
  const fs::path store = cached_path(flags, recipe);
  fs::create_directories(store.parent_path());
  if (const Cached cached = look_up(store, methods); cached == Cached::Damaged) {
    std::error_code ignored;
    fs::remove_all(store, ignored);
    build_store(recipe, store, Existing::Replace, flags.talk);
  } else if (cached != Cached::Whole) {
    build_store(recipe, store, Existing::Keep, flags.talk);
  }
  note_use(store);
  drop_oldest(store.parent_path(), store, kCacheLimit);
  return store;
}

void require_there(const fs::path& terrain) {
  if (!fs::exists(terrain) && !store::retired_store(terrain)) {
    throw Error(ErrorCode::NotFound,
                fmt::format("{}: no such file or directory: name a .arete store or a DEM",
                            terrain.string()));
  }
}

}  // namespace

fs::path cache_directory() {
  if (const char* const cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache == '/') {
    return fs::path(cache) / "arete";
  }
  if (const char* const home = std::getenv("HOME"); home != nullptr && *home != '\0') {
    return fs::path(home) / ".cache" / "arete";
  }
  throw Error(ErrorCode::NotFound,
              "HOME: not set, so there is no cache directory: set XDG_CACHE_HOME or build a store");
}

void drop_oldest(const fs::path& directory, const fs::path& keep, std::uintmax_t limit) {
  struct Entry {
    fs::path path;
    fs::file_time_type used;
    std::uintmax_t bytes;
  };
  std::vector<Entry> entries;
  std::uintmax_t total = 0;
  std::error_code gone;  // another process may clear up at the same time
  for (fs::directory_iterator it(directory, gone), end; !gone && it != end; it.increment(gone)) {
    std::error_code ignored;
    const auto used = it->last_write_time(ignored);
    const bool building = it->path().extension() == ".part" &&
                          fs::file_time_type::clock::now() - used < std::chrono::hours(24);
    if (ignored || building) {
      continue;
    }
    entries.push_back({it->path(), used, bytes_under(it->path())});
    total += entries.back().bytes;
  }
  std::ranges::sort(entries, {}, &Entry::used);
  for (const Entry& entry : entries) {
    if (total <= limit) {
      break;
    }
    if (entry.path != keep) {
      std::error_code ignored;
      fs::remove_all(entry.path, ignored);
      total -= entry.bytes;
    }
  }
}

fs::path store_of(const TerrainFlags& flags, const std::vector<std::string>& methods,
                  const BuildProgress& progress) {
  require_there(flags.terrain);
  return is_store(flags.terrain) ? flags.terrain : cached_store(flags, methods, progress);
}

std::optional<fs::path> ready_store(const TerrainFlags& flags,
                                    const std::vector<std::string>& methods) {
  require_there(flags.terrain);
  if (is_store(flags.terrain)) {
    return flags.terrain;
  }
  const fs::path store = cached_path(flags, recipe_of(flags, methods));
  if (look_up(store, methods) != Cached::Whole) {
    return std::nullopt;
  }
  note_use(store);
  return store;
}

std::size_t tile_bytes(Bytes cache) {
  return cache.count / 4;
}

std::unique_ptr<store::Terrain> open_store(const TerrainFlags& flags, const fs::path& store) {
  store::OpenOptions options;
  options.cache_bytes = tile_bytes(flags.cache);
  options.prefetch = flags.prefetch;
  if (flags.io == Io::Map) options.open = store::map_file;
  return store::Terrain::open(store, options);
}

std::unique_ptr<store::Terrain> open_terrain(const TerrainFlags& flags,
                                             const std::vector<std::string>& methods) {
  return open_store(flags, store_of(flags, methods));
}

void tell_of_damage(const store::Terrain& terrain, const TerrainFlags& flags) {
  if (terrain.cache_stats().damaged == 0) return;
  const std::string store = flags.terrain.string();
  fmt::print(stderr,
             "note: {}: parts are damaged and were drawn coarser: see arete info {} --check\n",
             store, store);
}

std::unique_ptr<lod::Engine> open_method(const TerrainFlags& flags, const std::string& method,
                                         const store::Terrain& terrain) {
  lod::Params params = params_of(flags.method_flags, method);
  if (has_pages(method)) {  // what --set says goes first
    params.emplace("pages",
                   std::to_string(std::max<std::size_t>(tile_bytes(flags.cache) / 4096, 1)));
    params.emplace("prefetch", flags.prefetch ? "on" : "off");
  }
  return lod::find_engine(method).open(terrain, params);
}

}  // namespace arete::app
