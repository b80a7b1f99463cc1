#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "arete/raster/dem.h"
#include "arete/raster/synthetic.h"

#include "flags.h"
#include "verbs.h"

namespace arete::app {
namespace {

struct SynthFlags {
  std::filesystem::path output;
  int size = 1025;
  raster::SyntheticKind kind = raster::SyntheticKind::Fbm;
  std::uint64_t seed = 1;
  Talk talk = Talk::Normal;
};

const std::map<std::string, raster::SyntheticKind> kKinds{
    {"fbm", raster::SyntheticKind::Fbm},           {"ridged", raster::SyntheticKind::Ridged},
    {"terraces", raster::SyntheticKind::Terraces}, {"flat", raster::SyntheticKind::Flat},
    {"slope", raster::SyntheticKind::Slope},
};

}  // namespace

void add_synth(CLI::App& app) {
  auto flags = std::make_shared<SynthFlags>();
  CLI::App* const verb = add_verb(app, "synth", "Make a synthetic DEM as GeoTIFF",
                                  "arete synth -o ridges.tif --size 2049 --kind ridged --seed 7");
  verb->add_option("-o,--output", flags->output, "The GeoTIFF; must not exist")->required();
  verb->add_option("--size", flags->size, "Posts a side, 30 m apart")
      ->required()
      ->check(CLI::Range(1, 65537));
  add_choice(*verb, "--kind", flags->kind, kKinds, "fbm, ridged, terraces, flat or slope [fbm]")
      ->type_name("KIND");
  verb->add_option("--seed", flags->seed, "Another seed is another terrain")->capture_default_str();
  add_quiet(*verb, flags->talk);
  verb->callback([flags] {
    const auto source = raster::synthesize(flags->kind, flags->size, flags->seed);
    raster::write_geotiff(*source, flags->output);
  });
}

}  // namespace arete::app
