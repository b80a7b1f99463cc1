#pragma once

#include <atomic>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "arete/core/error.h"
#include "arete/store/file.h"

namespace arete::store {

/// A file in memory that may be made to fail.
class MemoryFile : public File {
 public:
  explicit MemoryFile(std::vector<char> bytes) : bytes_(std::move(bytes)) {}
  std::uint64_t size() const override { return bytes_.size(); }
  void read_at(std::uint64_t offset, std::span<std::byte> out) const override {
    if (fail_from && offset + out.size() > *fail_from) throw Error(ErrorCode::Io, "planted EIO");
    if (offset + out.size() > bytes_.size()) throw Error(ErrorCode::Corrupt, "file ends");
    if (!out.empty()) std::memcpy(out.data(), bytes_.data() + offset, out.size());
  }

  /// Reads that touch this byte or later ones fail.
  std::shared_ptr<std::atomic<std::uint64_t>> fail_from;

 private:
  std::vector<char> bytes_;
};

}  // namespace arete::store
