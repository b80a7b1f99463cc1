#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "arete/store/terrain.h"

namespace arete::store {

inline constexpr std::size_t kTilePostCount = std::size_t{kTilePosts} * kTilePosts;

/// The raw form of a height tile, before block compression: residuals of a predictor, zigzag,
/// split into byte planes; docs/format.md. Requires: counts of kTilePostCount posts, valid the same
/// or empty. Lossless for any counts.
void encode_tile(std::span<const std::int32_t> counts, std::span<const std::uint8_t> valid,
                 std::vector<std::byte>& raw);

/// Throws: Corrupt when `raw` is no tile.
void decode_tile(std::span<const std::byte> raw, HeightTile& tile);

}  // namespace arete::store
