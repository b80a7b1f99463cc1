#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/store/terrain.h"

#include "flags.h"
#include "recipe.h"
#include "verbs.h"

namespace arete::app {
namespace {

namespace fs = std::filesystem;

struct BuildFlags {
  Recipe recipe;
  fs::path output;
  std::string methods = "all";
  Bytes memory{std::size_t{1} << 30U};
  std::optional<double> nodata;
  FrameSize raw_size{0, 0};
  Existing existing = Existing::Keep;
  Talk talk = Talk::Normal;
};

const std::map<std::string, raster::Unit> kUnits{
    {"m", raster::Unit::Metre},
    {"ft", raster::Unit::Foot},
    {"us-ft", raster::Unit::UsSurveyFoot},
};
const std::map<std::string, raster::Encoding> kEncodings{
    {"terrain-rgb", raster::Encoding::TerrainRgb},
    {"terrarium", raster::Encoding::Terrarium},
};

void add_dem_flags(CLI::App& verb, BuildFlags& flags) {
  raster::DemOptions& dem = flags.recipe.dem;
  verb.add_option("--crs", dem.crs, "Reproject to this CRS")->type_name("EPSG:N");
  verb.add_option("--source-crs", dem.source_crs, "The DEM's CRS, in place of the file's")
      ->type_name("EPSG:N");
  verb.add_option("--band", dem.band, "Band to read, from 1 [the first]")
      ->check(CLI::Range(1, 65535));
  add_choice(verb, "--encoding", dem.encoding, kEncodings,
             "terrain-rgb or terrarium, for RGB pictures")
      ->type_name("E");
  add_choice(verb, "--unit", dem.unit, kUnits, "m, ft or us-ft [the file's]")->type_name("UNIT");
  verb.add_option("--nodata", flags.nodata, "This value means no data, besides the file's own");
  verb.add_option("--z-scale", dem.z_scale, "Vertical exaggeration")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  add_quantity(verb, "--size", flags.raw_size, "Columns and rows of a .r16 or .r32 file")
      ->type_name("WxH");
  verb.add_option("--drape", flags.recipe.drape, "An image to lay over the land")
      ->type_name("IMAGE");
}

void add_work_flags(CLI::App& verb, BuildFlags& flags) {
  verb.add_option("--methods", flags.methods, "all, or names separated by commas")
      ->capture_default_str();
  add_settings(verb, flags.recipe.method_flags);
  add_quantity(verb, "--memory-limit", flags.memory, "Most bytes of memory [1G]")
      ->type_name("BYTES");
  verb.add_option("--threads", flags.recipe.threads, "Threads to work with")
      ->capture_default_str()
      ->check(CLI::Range(1, 1024));
  verb.add_flag_callback(
      "--force", [&flags] { flags.existing = Existing::Replace; }, "Build although it exists");
  add_quiet(verb, flags.talk);
}

/// Empty when there is no store that can be read.
std::string store_id(const fs::path& store) {
  store::OpenOptions options;
  options.prefetch = false;
  try {
    return store::Terrain::open(store, options)->manifest().id;
  } catch (const Error&) {
    return {};
  }
}

void run(BuildFlags& flags) {
  Recipe& recipe = flags.recipe;
  recipe.methods = method_list(flags.methods);
  recipe.memory_limit = flags.memory.count;
  recipe.dem.nodata = flags.nodata;
  if (flags.raw_size.width != 0) {
    recipe.dem.raw_size = std::pair{flags.raw_size.width, flags.raw_size.height};
  }
  const std::string before = store_id(flags.output);
  build_store(recipe, flags.output, flags.existing, flags.talk);
  if (flags.talk == Talk::Normal) {
    fmt::print("{}: {}\n", flags.output.string(),
               store_id(flags.output) == before ? "up to date" : "built");
  }
}

}  // namespace

void add_build(CLI::App& app) {
  auto flags = std::make_shared<BuildFlags>();
  CLI::App* const verb = add_verb(app, "build", "Make a store from a DEM of any size",
                                  "arete build alps.tif -o alps.arete --drape alps.jpg");
  verb->add_option("DEM", flags->recipe.dems, "One file, or several neighbouring ones")->required();
  verb->add_option("-o,--output", flags->output, "The store: a directory NAME.arete")->required();
  add_dem_flags(*verb, *flags);
  add_work_flags(*verb, *flags);
  verb->callback([flags] { run(*flags); });
}

}  // namespace arete::app
