#include <memory>

#include "flags.h"
#include "verbs.h"
#include "viewer.h"

namespace arete::app {

void add_view(CLI::App& app) {
  auto flags = std::make_shared<ViewFlags>();
  flags->flight.path.clear();
  CLI::App* const verb =
      add_verb(app, "view", "Fly over the terrain in a window",
               "arete view alps.arete --method smooth --tolerance 2\n\n"
               "In the window:\n"
               "  left drag pans, right drag or wheel zooms, middle drag turns,\n"
               "  double click flies there, Space flies home, F flies by W A S D,\n"
               "  H lists all keys; a file dropped on the window is opened.\n"
               "A DEM shows a preview while its store is built.");
  add_terrain(*verb, flags->flight.terrain);
  add_method(*verb, flags->method);
  add_flight(*verb, flags->flight);
  CLI::Option* const shot =
      verb->add_option("--screenshot", flags->screenshot,
                       "Fly the path in --frames frames, save the last picture, and quit")
          ->type_name("PNG");
  verb->add_option("--frames", flags->flight.frames, "Frames before the screenshot")
      ->capture_default_str()
      ->check(CLI::Range(1, 1'000'000))
      ->needs(shot);
  verb->add_option("--trace", flags->trace,
                   "Write the flight as CSV, a line a frame: camera, ground under the mouse, times")
      ->type_name("CSV");
  add_quiet(*verb, flags->flight.terrain.talk);
  verb->callback([flags] { Viewer(*flags).run(); });
}

}  // namespace arete::app
