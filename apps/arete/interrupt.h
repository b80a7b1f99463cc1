#pragma once

#include <string_view>

namespace arete::app {

/// From now on the first Ctrl-C (or SIGTERM) only sets a flag; a second one ends the process.
void catch_interrupts();
/// From now on a write beyond `ulimit -f` fails instead of ending the process.
void turn_size_limit_into_error();
bool interrupted();
/// Throws: Cancelled once interrupted, saying what was stopped.
void stop_if_interrupted(std::string_view file);

}  // namespace arete::app
