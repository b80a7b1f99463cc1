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
};

/// A regular file read by pread. Throws: NotFound, Io.
std::unique_ptr<File> open_file(const std::filesystem::path& path);

}  // namespace arete::store
