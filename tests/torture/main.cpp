#include <exception>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "torture/verbs.h"

namespace {

using namespace arete::torture;

void add_crashsim(CLI::App& app, int& faults) {
  static CrashOptions o;
  CLI::App* const verb = app.add_subcommand("crashsim", "Disk states that a power cut may leave");
  verb->add_option("--states", o.states)->capture_default_str();
  verb->add_option("--control-states", o.control_states)->capture_default_str();
  verb->add_option("--resumes", o.resumes)->capture_default_str();
  verb->callback([&faults] { faults = crashsim(o); });
}

void add_bitflip(CLI::App& app, int& faults) {
  static FlipOptions o;
  CLI::App* const verb = app.add_subcommand("bitflip", "Single flipped bits of a small store");
  verb->add_option("--stride", o.stride, "Every N-th bit")->capture_default_str();
  verb->add_option("--whole", o.whole)->capture_default_str();
  verb->add_option("--threads", o.threads)->capture_default_str();
  verb->callback([&faults] { faults = bitflip(o); });
}

void add_trunc(CLI::App& app, int& faults) {
  CLI::App* const verb =
      app.add_subcommand("trunc", "Shortened files, also under an open reader; swapped pages");
  verb->callback([&faults] { faults = trunc(); });
}

void add_kill9(CLI::App& app, int& faults) {
  static KillOptions o;
  CLI::App* const verb = app.add_subcommand("kill9", "kill -9 of the real build, readers watching");
  verb->add_option("--arete", o.arete, "The program")->required();
  verb->add_option("--points", o.points)->capture_default_str();
  verb->add_option("--readers", o.readers)->capture_default_str();
  verb->add_option("--size", o.size, "Posts a side")->capture_default_str();
  verb->callback([&faults] { faults = kill9(o); });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Breaks stores on purpose and counts what is not noticed.", "arete_torture");
  app.require_subcommand(1);
  int faults = 0;
  add_crashsim(app, faults);
  add_bitflip(app, faults);
  add_trunc(app, faults);
  add_kill9(app, faults);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    fmt::print(stderr, "arete_torture: {}\n", error.what());
    return 1;
  }
  fmt::print("{}\n", faults == 0 ? "no fault" : "FAULTS FOUND");
  return faults == 0 ? 0 : 1;
}
