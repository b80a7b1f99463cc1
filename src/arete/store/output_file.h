#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace arete::store {

/// A new file beside its final place. Dropped without publish() it is unlinked.
/// Every failure throws Io with the system's reason; "disk full" says what to do.
class OutputFile {
 public:
  /// Creates `path` + ".tmp"; one left over by a killed build is replaced.
  explicit OutputFile(std::filesystem::path path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Reserves disk space, so that a full disk is met here.
  void allocate(std::uint64_t bytes);
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);
  /// Asks the kernel to begin writing out; does not wait.
  void start_writeback();
  /// fsync. A failure is final: it is never tried again.
  void sync();
  /// Renames the file to its final name. Not on disk before sync_file and sync_directory.
  void publish();

 private:
  std::filesystem::path path_, temporary_;
  int fd_ = -1;
};

/// fsync of a file or of a directory's entries. A failure is final: it is never tried again.
/// Throws: Io.
void sync_file(const std::filesystem::path& file);
void sync_directory(const std::filesystem::path& directory);

/// fsync of the directory that names `path`. Throws: Io.
void sync_parent(const std::filesystem::path& path);

/// temp + write + fsync + rename + fsync of the directory. Throws: Io.
void write_file_durably(const std::filesystem::path& path, std::span<const std::byte> bytes);

}  // namespace arete::store
