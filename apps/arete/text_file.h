#pragma once

#include <filesystem>
#include <string_view>

namespace arete::app {

/// Replaces the file as a whole. Throws: Io; the old file, or none, is left then.
void write_text(const std::filesystem::path& file, std::string_view text);

}  // namespace arete::app
