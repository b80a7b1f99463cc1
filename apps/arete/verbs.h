#pragma once

#include <CLI/CLI.hpp>

namespace arete::app {

// Each adds its verb to the program; the verb runs while the command line is parsed.
// A verb only parses, calls the rooms and prints. It throws arete::Error for any failure.
void add_build(CLI::App& app);
void add_info(CLI::App& app);
void add_view(CLI::App& app);
void add_render(CLI::App& app);
void add_verify(CLI::App& app);
void add_bench(CLI::App& app);
void add_export(CLI::App& app);
void add_synth(CLI::App& app);

}  // namespace arete::app
