#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "arete/lod/bintree/record.h"

namespace arete::lod::bintree {

/// A page as the store compresses it: the first bytes of all records, then the second, and so on,
/// after count has been replaced by its zigzagged difference from the record before it. Requires:
/// kPageRecords records.
void encode_page(std::span<const Record> records, std::vector<std::byte>& raw);

/// False when `raw` has not the size of a page; any other bytes decode to some records.
[[nodiscard]] bool decode_page(std::span<const std::byte> raw, std::span<Record> records);

}  // namespace arete::lod::bintree
