#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "arete/core/screen_error.h"
#include "arete/lod/engine.h"

namespace arete::app {

/// What the command line says about methods.
struct MethodFlags {
  std::string patch;                  ///< posts a side of a patch; empty = the method's own choice
  std::vector<std::string> settings;  ///< "NAME=VALUE" or "METHOD.NAME=VALUE"
};

/// The settings that concern this method. Throws: Usage for one without "=".
lod::Params params_of(const MethodFlags& flags, std::string_view method);

/// Methods that keep pages of their own, as many as the param "pages" says.
bool has_pages(std::string_view method);

/// "all", or names separated by commas, in the order of lod::engines() without repeats.
/// Throws: Usage, listing the names.
std::vector<std::string> method_list(std::string_view names);

/// "up", "ang" or "rig". Throws: Usage.
ErrorScale error_scale(std::string_view name);
std::string_view scale_name(ErrorScale scale);

}  // namespace arete::app
