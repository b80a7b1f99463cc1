#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "arete/core/parallel.h"
#include "arete/raster/dem.h"

#include "method_flags.h"
#include "progress.h"

namespace arete::app {

/// Told a step's name and its share done, 0..1, on the thread that builds; false cancels.
using BuildProgress = std::function<bool(std::string_view step, double done)>;

/// All that decides a store's bytes, and how to make them.
struct Recipe {
  std::vector<std::filesystem::path> dems;
  raster::DemOptions dem;
  std::filesystem::path drape;  ///< an image, or empty
  std::vector<std::string> methods;
  MethodFlags method_flags;
  std::size_t memory_limit = std::size_t{1} << 30U;  ///< bytes
  int threads = default_threads();
  BuildProgress progress{};  ///< besides the progress bar; may be empty
};

enum class Existing { Keep, Replace };

/// The recipe's inputs as text: absolute paths, sizes, mtimes and options. Two recipes with the
/// same key make the same bytes but for their methods. Throws: NotFound.
std::string source_key(const Recipe& recipe);

/// Builds or completes the store with a progress bar, printing notes on what was assumed to
/// stderr unless quiet. Ctrl-C stops it; the next call goes on from there.
/// Throws: as raster::open_dem and store::build.
void build_store(const Recipe& recipe, const std::filesystem::path& store, Existing existing,
                 Talk talk);

/// Builds a new store from a source instead of the recipe's DEMs, saying nothing. Throws: as
/// store::build.
void build_quietly(const Recipe& recipe, HeightSource& source, const std::filesystem::path& store);

}  // namespace arete::app
