#pragma once

#include <nlohmann/json.hpp>

namespace arete::app {

/// Keys stay in the order in which they are written.
using Json = nlohmann::ordered_json;

/// To stdout, indented, with a line end. Bytes that are not UTF-8 are replaced.
void print_json(const Json& json);

/// What these numbers are worth: CPU, cores, system, and the GL renderer when there is one.
Json machine_json(const std::string& gl_renderer);

}  // namespace arete::app
