#include "recipe.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/lod/engine.h"
#include "arete/store/build.h"

#include "interrupt.h"

namespace arete::app {
namespace {

namespace fs = std::filesystem;

std::string file_key(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  if (error) {
    throw Error(ErrorCode::NotFound, fmt::format("{}: cannot be read: {}: check the name",
                                                 file.string(), error.message()));
  }
  const auto changed = fs::last_write_time(file).time_since_epoch().count();
  return fmt::format("{}|{}|{}\n", fs::absolute(file).lexically_normal().string(), size, changed);
}

// Headers and projections beside a DEM decide what it means, too.
std::string dem_key(const fs::path& dem) {
  std::string key = file_key(dem);
  for (const char* suffix :
       {".hdr", ".HDR", ".prj", ".PRJ", ".lbl", ".LBL", ".img", ".IMG", ".dat"}) {
    fs::path beside = dem;
    beside.replace_extension(suffix);
    std::error_code ignored;
    if (beside != dem && fs::is_regular_file(beside, ignored)) {
      key += file_key(beside);
    }
  }
  return key;
}

std::string options_key(const raster::DemOptions& o) {
  const auto [cols, rows] = o.raw_size.value_or(std::pair{0, 0});
  return fmt::format("band={} encoding={} unit={} nodata={} z_scale={} source_crs={} crs={} {}x{}",
                     o.band, static_cast<int>(o.encoding), static_cast<int>(o.unit),
                     o.nodata ? fmt::format("{}", *o.nodata) : "file", o.z_scale, o.source_crs,
                     o.crs, cols, rows);
}

BuildContext context_of(const Recipe& recipe, ProgressBar& bar) {
  BuildContext context;
  context.threads = recipe.threads;
  // A picture over the land is kept in memory and takes the other half.
  context.memory_limit = recipe.memory_limit / (recipe.drape.empty() ? 1 : 2);
  context.progress = [&bar, &recipe](std::string_view step, double done) {
    bar.show(step, done);
    return !interrupted() && (!recipe.progress || recipe.progress(step, done));
  };
  return context;
}

store::BuildOptions options_of(const Recipe& recipe, const fs::path& store, Existing existing,
                               const BuildContext& context) {
  store::BuildOptions options;
  options.output = store;
  options.force = existing == Existing::Replace;
  options.source_key = source_key(recipe);
  options.methods = recipe.methods;
  options.preprocess = [&recipe, &context](const store::Terrain& terrain, store::Writers& writers) {
    for (const std::string& method : recipe.methods) {
      lod::find_engine(method).preprocess(terrain, writers, context,
                                          params_of(recipe.method_flags, method));
    }
  };
  return options;
}

void run_build(const Recipe& recipe, const fs::path& store, Existing existing, Talk talk) {
  raster::DemOptions dem = recipe.dem;
  dem.memory_limit = recipe.memory_limit;
  const std::unique_ptr<HeightSource> source = raster::open_dem(recipe.dems, dem);
  std::unique_ptr<RasterSource> drape;
  if (!recipe.drape.empty()) {
    drape = raster::open_drape(recipe.drape, source->cols(), source->rows(), source->georef(),
                               recipe.memory_limit / 2);
  }
  ProgressBar bar(talk);
  const BuildContext context = context_of(recipe, bar);
  store::BuildOptions options = options_of(recipe, store, existing, context);
  options.drape = drape.get();
  store::build(*source, options, context);
  if (talk == Talk::Normal) {
    // Only now: some notes are known when all rows are read, and a failure says one line alone.
    for (const std::string& note : source->georef().notes) {
      fmt::print(stderr, "note: {}\n", note);
    }
  }
}

}  // namespace

std::string source_key(const Recipe& recipe) {
  std::string key;
  for (const fs::path& dem : recipe.dems) {
    key += dem_key(dem);
  }
  if (!recipe.drape.empty()) {
    key += "drape " + file_key(recipe.drape);
  }
  return key + options_key(recipe.dem);
}

void build_store(const Recipe& recipe, const fs::path& store, Existing existing, Talk talk) {
  try {
    run_build(recipe, store, existing, talk);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Cancelled) {
      throw;
    }
    throw Error(ErrorCode::Cancelled,
                fmt::format("{}: interrupted: run the same command again to go on from here",
                            store.string()));
  }
}

void build_quietly(const Recipe& recipe, HeightSource& source, const fs::path& store) {
  ProgressBar bar(Talk::Quiet);
  const BuildContext context = context_of(recipe, bar);
  store::build(source, options_of(recipe, store, Existing::Replace, context), context);
}

}  // namespace arete::app
