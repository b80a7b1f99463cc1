#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "arete/core/error.h"

#include "interrupt.h"
#include "verbs.h"

namespace {

constexpr int kFailed = 1;
constexpr int kUsage = 2;

int fail(std::string text, int code) {
  std::ranges::replace(text, '\n', ' ');
  fmt::print(stderr, "arete: {}\n", text);
  return code;
}

std::string verb_of(const CLI::App& app) {
  const auto verbs = app.get_subcommands();
  return verbs.empty() ? "arete" : "arete " + verbs.front()->get_name();
}

int parse_and_run(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::Success& wanted) {  // --help, --version
    return app.exit(wanted);
  } catch (const CLI::ParseError& error) {
    return fail(fmt::format("{}: see {} --help", error.what(), verb_of(app)), kUsage);
  } catch (const arete::Error& error) {
    return fail(error.what(), error.code() == arete::ErrorCode::Usage ? kUsage : kFailed);
  } catch (const std::bad_alloc&) {
    return fail("memory: not enough: lower --cache or --memory-limit", kFailed);
  } catch (const std::exception& error) {
    return fail(fmt::format("unexpected: {}: please report this", error.what()), kFailed);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Arete draws elevation models in real time and proves what it draws.", "arete");
  app.set_version_flag("--version", "arete " ARETE_VERSION);
  app.require_subcommand(1);
  app.footer("\nRun 'arete VERB --help' for a verb's flags and an example.");
  arete::app::add_build(app);
  arete::app::add_info(app);
  arete::app::add_view(app);
  arete::app::add_render(app);
  arete::app::add_verify(app);
  arete::app::add_bench(app);
  arete::app::add_export(app);
  arete::app::add_synth(app);
  arete::app::catch_interrupts();
  arete::app::turn_size_limit_into_error();
  return parse_and_run(app, argc, argv);
}
