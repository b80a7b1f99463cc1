#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arete/store/hash.h"

/// The segment file, byte for byte; docs/format.md says the same in words.
///
///   page 0       header
///   pages 1...   blocks, params, directory (each of the last two begins a page)
///   then         page table: xxh3-64 of every page before it, seeded by the page's number
///   last page    footer
namespace arete::store {

inline constexpr std::size_t kPageBytes = 4096;
inline constexpr std::uint16_t kVersionMajor = 1;
inline constexpr std::uint16_t kVersionMinor = 0;
/// Feature bits that this build reads; a reader refuses a required bit that it does not know.
inline constexpr std::uint64_t kKnownRequired = 0;
inline constexpr std::size_t kMaxBlockBytes = std::size_t{64} << 20U;
inline constexpr std::size_t kMaxParamsBytes = std::size_t{1} << 20U;
inline constexpr std::size_t kNameBytes = 64;
inline constexpr std::size_t kEntryBytes = 32;
/// Blocks begin at multiples of this.
inline constexpr std::uint64_t kBlockAlign = 16;

using Page = std::array<std::byte, kPageBytes>;

/// Offsets and sizes are bytes from the start of the file.
struct SegmentHeader {
  std::uint16_t version_major = kVersionMajor, version_minor = kVersionMinor;
  std::uint64_t required_features = 0, optional_features = 0;
  std::uint64_t file_bytes = 0;
  std::uint64_t params_offset = 0, params_bytes = 0;
  std::uint64_t directory_offset = 0, block_count = 0;
  std::uint64_t page_table_offset = 0;
  Hash128 id;        ///< of name, params and every block's key and content
  std::string name;  ///< at most kNameBytes - 1 of a-z, 0-9, '-'
};

struct SegmentFooter {
  std::uint64_t file_bytes = 0;
  std::uint64_t page_table_offset = 0;
  std::uint64_t page_table_hash = 0;  ///< xxh3-64 of the page table with its padding
  std::uint64_t header_hash = 0;      ///< the header page's own hash
};

/// One block. stored_bytes == raw_bytes means that the bytes stand as they are, else zstd.
struct BlockEntry {
  std::uint64_t key = 0;
  std::uint64_t offset = 0;
  std::uint32_t stored_bytes = 0, raw_bytes = 0;
  std::uint64_t raw_hash = 0;  ///< xxh3-64 of the raw bytes
};

Page encode_header(const SegmentHeader& header);
Page encode_footer(const SegmentFooter& footer);
/// Checks magic, hash, version, features, and that all offsets fit `file_bytes`.
/// Throws: Corrupt, Unsupported, naming `file`.
SegmentHeader decode_header(const Page& page, std::uint64_t file_bytes, const std::string& file);
SegmentFooter decode_footer(const Page& page, const std::string& file);
/// The hash that a header or footer page carries at its end.
std::uint64_t own_hash(const Page& page);

void append_entry(const BlockEntry& entry, std::vector<std::byte>& out);
/// Requires: kEntryBytes bytes.
BlockEntry decode_entry(std::span<const std::byte> bytes);

bool is_segment_name(std::string_view name);
inline std::uint64_t page_ceil(std::uint64_t bytes) {
  return (bytes + kPageBytes - 1) / kPageBytes * kPageBytes;
}

}  // namespace arete::store
