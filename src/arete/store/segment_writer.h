#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "arete/store/format.h"
#include "arete/store/output_file.h"
#include "arete/store/terrain.h"

namespace arete::store {

/// Writes one segment file from blocks in their stored form. The file stands under its name after
/// finish(), but is durable only after sync_file and sync_directory; dropped earlier it vanishes.
class SegmentWriter {
 public:
  /// Lays the file out and reserves its space; offsets in `entries` are ignored.
  /// Requires: keys ascend. Throws: Io.
  SegmentWriter(const std::filesystem::path& path, std::string name, std::string params,
                std::vector<BlockEntry> entries);
  /// The next block's stored bytes, in the order of the entries. Throws: Io.
  void append(std::span<const std::byte> stored);
  /// Writes params, directory, page table and footer. Throws: Io.
  SegmentRecord finish();

 private:
  void put(std::span<const std::byte> bytes);
  void pad_to(std::uint64_t offset);
  void flush();

  OutputFile file_;
  SegmentHeader header_;
  std::string params_;
  std::vector<BlockEntry> entries_;
  std::size_t next_entry_ = 0;
  std::vector<std::byte> buffer_;  ///< whole pages not yet written, from flushed_ on
  std::uint64_t flushed_ = 0;
  std::vector<std::uint64_t> page_table_;
};

}  // namespace arete::store
