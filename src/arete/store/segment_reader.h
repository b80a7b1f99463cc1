#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "arete/store/file.h"
#include "arete/store/format.h"

namespace arete::store {

/// Pages hashes every page that a block lies on before it is decoded, and the decoded bytes.
/// Nothing is the negative control of the damage tests: no hash is looked at.
enum class Verify { Pages, Nothing };

/// One opened segment file. Thread contract: safe from several threads at once.
class SegmentReader {
 public:
  /// Checks header, footer, page table, params and directory. `label` names the file in errors.
  /// Throws: Corrupt, Unsupported, Io.
  SegmentReader(std::unique_ptr<File> file, std::string label, Verify verify = Verify::Pages);

  const std::string& name() const { return header_.name; }
  const std::string& label() const { return label_; }
  const std::string& params() const { return params_; }
  std::string id() const { return header_.id.hex(); }
  std::uint64_t bytes() const { return header_.file_bytes; }
  std::span<const std::uint64_t> keys() const { return keys_; }  ///< ascending
  bool contains(std::uint64_t key) const;

  /// Reads a block into `raw`. Returns the bytes read from the file; 0 when there is no such block.
  /// Throws: Corrupt, Io.
  std::size_t read(std::uint64_t key, std::vector<std::byte>& raw) const;

  void drop_os_cache() const { file_->drop_os_cache(); }

  /// Memory that the reader holds: 40 bytes a block and 8 bytes a page.
  std::uint64_t table_bytes() const {
    return keys_.size() * sizeof keys_[0] + entries_.size() * sizeof entries_[0] +
           page_table_.size() * sizeof page_table_[0];
  }
  std::uint64_t page_count() const { return header_.file_bytes / kPageBytes; }
  /// Verifies pages [first, first + count) of those before the page table; the others were
  /// verified at open. Throws: Corrupt, Io.
  void check_pages(std::uint64_t first, std::uint64_t count) const;
  /// Verifies every page. Throws: Corrupt, Io.
  void check_all(const std::function<void(std::uint64_t pages_done)>& progress = {}) const;

 private:
  void read_page_table();
  void read_params_and_directory();
  void check_entry(std::size_t i) const;
  std::vector<std::byte> read_verified(std::uint64_t offset, std::uint64_t bytes) const;
  void verify_pages(std::uint64_t first_page, std::span<const std::byte> pages) const;

  std::unique_ptr<File> file_;
  std::string label_;
  Verify verify_;
  SegmentHeader header_;
  std::vector<std::uint64_t> page_table_;
  std::string params_;
  std::vector<std::uint64_t> keys_;
  std::vector<BlockEntry> entries_;
};

}  // namespace arete::store
