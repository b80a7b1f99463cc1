#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

namespace arete::store {

/// The one seam for reading: a size and read-at. Thread contract: safe from several threads at
/// once.
class File {
 public:
  virtual ~File() = default;
  virtual std::uint64_t size() const = 0;
  /// Fills `out` from `offset`. Throws: Io; Corrupt when the file ends first.
  virtual void read_at(std::uint64_t offset, std::span<std::byte> out) const = 0;
  /// Asks the system to forget what it holds of the file, so that reads are cold: for measurements.
  /// Does nothing where that cannot be asked for. Throws: nothing.
  virtual void drop_os_cache() const {}
};

/// A regular file read by pread. Throws: NotFound, Io.
std::unique_ptr<File> open_file(const std::filesystem::path& path);

/// The same through a read-only mapping: reads are copies out of it, bounds-checked. A file that
/// shrinks or cannot be read while it is mapped ends the program (SIGBUS), so this is for
/// measurements (`bench --io mmap`) only. Throws: NotFound, Io.
std::unique_ptr<File> map_file(const std::filesystem::path& path);

}  // namespace arete::store
