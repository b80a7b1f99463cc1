#pragma once

#include <filesystem>
#include <memory>

#include "arete/store/terrain.h"

namespace arete::bench {

/// A ridged terrain of 1025 x 1025 posts, built for all methods in a temporary directory that goes
/// with the process.
const std::filesystem::path& built_store();
std::unique_ptr<store::Terrain> open_built_store();

}  // namespace arete::bench
