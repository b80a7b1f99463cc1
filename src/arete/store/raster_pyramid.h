#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "arete/core/raster_source.h"
#include "arete/store/segment_reader.h"

namespace arete::store {

/// The params text of a segment that holds a pyramid of texels: `heading` (what decides its
/// content), then the shape. Keys of its blocks are TileId::key().
std::string raster_params(const RasterShape& shape, const std::string& heading);
/// The shape; nothing when the params are not of a pyramid.
std::optional<RasterShape> parse_raster_params(const std::string& params);

/// The pyramid in a segment. A block that fails adds 1 to *damaged. Both must outlive it.
/// Throws: Corrupt when the segment is no pyramid.
std::unique_ptr<RasterSource> open_raster(const SegmentReader& segment,
                                          std::atomic<std::uint64_t>* damaged);

/// A tile of nothing but `fill`.
Texels filled_tile(const RasterShape& shape);

/// Block form of a tile: channels apart, each texel less its western neighbour (the first of a row
/// less the one above), modulo 256.
void encode_texels(const Texels& texels, std::vector<std::byte>& raw);
/// Requires: raw of size * size * channels bytes, the size and channels of `texels`.
void decode_texels(std::span<const std::byte> raw, Texels& texels);

}  // namespace arete::store
