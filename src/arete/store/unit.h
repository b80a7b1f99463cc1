#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "arete/store/file.h"
#include "arete/store/format.h"
#include "arete/store/hash.h"
#include "arete/store/output_file.h"

namespace arete::store {

/// Writes one finished piece of a segment into its own small file, so that a killed build need not
/// make it again: stored blocks, `aux` bytes for the builder, index, trailer with a hash of it all.
class UnitWriter {
 public:
  /// `unit_key` names what the unit is made from; a file with another key is not used.
  UnitWriter(const std::filesystem::path& file, std::uint64_t unit_key);
  /// Compresses and keeps `raw`. Requires: keys ascend.
  void add(std::uint64_t key, std::span<const std::byte> raw);
  void set_aux(std::vector<std::byte> aux) { aux_ = std::move(aux); }
  /// The unit stands under its name after this. Throws: Io.
  void finish();

 private:
  void flush();

  OutputFile file_;
  std::uint64_t unit_key_;
  std::vector<BlockEntry> entries_;
  std::vector<std::byte> buffer_, aux_;
  std::uint64_t flushed_ = 0;
  Hasher hasher_;
};

/// A finished unit. Thread contract: safe from several threads at once.
class UnitReader {
 public:
  enum class Trust {
    Verify,   ///< hash the whole file: it may come from a killed build
    ThisRun,  ///< check the trailer only: this build made or verified it
  };
  /// Null when the file is absent, of another key or (Verify) not whole.
  static std::unique_ptr<UnitReader> open(const std::filesystem::path& file, std::uint64_t unit_key,
                                          Trust trust);
  std::span<const BlockEntry> entries() const { return entries_; }
  std::span<const std::byte> aux() const { return aux_; }
  /// False when there is no such block. Throws: Corrupt, Io.
  bool read(std::uint64_t key, std::vector<std::byte>& raw) const;
  /// Stored bytes of entry i.
  void read_stored(std::size_t i, std::vector<std::byte>& stored) const;

 private:
  explicit UnitReader(const std::filesystem::path& file);
  bool read_index(std::uint64_t unit_key, Trust trust);
  std::uint64_t hash_of_file(std::uint64_t bytes) const;

  std::unique_ptr<File> file_;
  std::string file_name_;
  std::vector<BlockEntry> entries_;
  std::vector<std::byte> aux_;
};

/// The units of one kind in a part directory.
class UnitFolder {
 public:
  /// `content` is all that decides the units' bytes.
  UnitFolder(std::filesystem::path folder, std::string name, const std::string& content);
  /// True when the unit is there and its hash is right.
  bool is_finished(int unit) const;
  /// A unit that this build made or found finished. Throws: Corrupt when it is not there.
  std::unique_ptr<UnitReader> open(int unit) const;
  /// Makes the unit unless it is finished.
  void make(int unit, const std::function<void(UnitWriter&)>& fill) const;
  /// Deletes all units of the segment.
  void clear() const;

 private:
  std::filesystem::path path(int unit) const;
  std::uint64_t key(int unit) const;

  std::filesystem::path folder_;
  std::string name_;
  std::uint64_t content_hash_;
};

/// A unit that is finished; few of them may be open at once, so it is opened when needed.
struct UnitRef {
  UnitFolder folder;
  int unit = 0;
  std::unique_ptr<UnitReader> open() const { return folder.open(unit); }
};

}  // namespace arete::store
