#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace arete::store {

/// Appends the stored form of a block to `out`: zstd level 1, or the bytes themselves where that
/// would not be smaller. Returns the bytes appended. Requires: at most kMaxBlockBytes.
std::size_t compress_block(std::span<const std::byte> raw, std::vector<std::byte>& out);

/// Restores a block into `raw`, whose size is the block's raw size. False when the stored bytes are
/// not those of such a block.
bool decompress_block(std::span<const std::byte> stored, std::span<std::byte> raw);

}  // namespace arete::store
