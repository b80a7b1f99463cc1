#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "flags.h"

namespace arete::app {

/// Keys stay in the order in which they are written.
using Json = nlohmann::ordered_json;

/// To stdout, indented, with a line end. Bytes that are not UTF-8 are replaced.
void print_json(const Json& json);

/// JSON knows no infinity: null stands for "not promised" and "without bound".
Json finite(double value);

/// "options" of a report: what the flight was flown with.
Json options_json(const FlightFlags& flags, const std::string& method);

/// What these numbers are worth: CPU, cores, system, and the GL renderer when there is one.
Json machine_json(const std::string& gl_renderer);

}  // namespace arete::app
