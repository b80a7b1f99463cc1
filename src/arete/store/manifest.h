#pragma once

#include <string>
#include <string_view>

#include "arete/store/terrain.h"

namespace arete::store {

inline constexpr std::string_view kManifestName = "manifest.json";
inline constexpr int kFormatVersion = 1;
/// Posts a side that a store takes.
inline constexpr int kMaxSide = 1 << 24;

/// JSON whose last line is the hash of everything above it. Fills in nothing: set id first.
std::string to_text(const Manifest& manifest);
/// Throws: Corrupt, Unsupported, naming `file`.
Manifest parse_manifest(std::string_view text, const std::string& file);

/// Hash of grid, place, lattice and segments: equal ids mean equal terrains.
std::string manifest_id(const Manifest& manifest);

}  // namespace arete::store
