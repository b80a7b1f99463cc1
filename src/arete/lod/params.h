#pragma once

#include <initializer_list>
#include <string_view>

#include "arete/lod/engine.h"

namespace arete::lod {

/// The value of a parameter, or the default. Lifetime: that of `params`.
std::string_view param(const Params& params, std::string_view name, std::string_view otherwise);
/// A whole number in [low, high]. Throws: Usage.
int int_param(const Params& params, std::string_view name, int otherwise,
              std::pair<int, int> range);
/// "true" or "false", which is the default. Throws: Usage.
bool flag_param(const Params& params, std::string_view name);
/// Parameter "topology": list or strip. Throws: Usage.
Topology topology_param(const Params& params, Topology otherwise);
/// Throws: Usage when params hold a name that is not known.
void check_names(const Params& params, std::initializer_list<std::string_view> known);

}  // namespace arete::lod
