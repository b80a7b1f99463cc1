#include "built_store.h"

#include <string>

#include <unistd.h>

#include "arete/lod/engine.h"
#include "arete/raster/synthetic.h"
#include "arete/store/build.h"

namespace arete::bench {
namespace {

namespace fs = std::filesystem;

struct BuiltStore {
  BuiltStore() {
    const auto dem = raster::synthesize(raster::SyntheticKind::Ridged, 1025, 7);
    const BuildContext context;
    store::BuildOptions options;
    options.output = path;
    options.source_key = "bench";
    options.preprocess = [&](const store::Terrain& terrain, store::Writers& writers) {
      for (const lod::EngineInfo& engine : lod::engines()) {
        engine.preprocess(terrain, writers, context, {});
      }
    };
    store::build(*dem, options, context);
  }
  ~BuiltStore() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  fs::path path =
      fs::temp_directory_path() / ("arete_bench_" + std::to_string(getpid()) + ".arete");
};

}  // namespace

const fs::path& built_store() {
  static const BuiltStore store;
  return store.path;
}

std::unique_ptr<store::Terrain> open_built_store() {
  return store::Terrain::open(built_store());
}

}  // namespace arete::bench
