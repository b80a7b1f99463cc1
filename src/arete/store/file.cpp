#include "arete/store/file.h"

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "arete/core/error.h"

namespace arete::store {
namespace {

class PosixFile : public File {
 public:
  PosixFile(int fd, std::uint64_t size, std::string name)
      : fd_(fd), size_(size), name_(std::move(name)) {}
  ~PosixFile() override { ::close(fd_); }
  PosixFile(const PosixFile&) = delete;
  PosixFile& operator=(const PosixFile&) = delete;

  std::uint64_t size() const override { return size_; }

  void read_at(std::uint64_t offset, std::span<std::byte> out) const override {
    while (!out.empty()) {
      const ssize_t n = ::pread(fd_, out.data(), out.size(), static_cast<off_t>(offset));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0)
        throw Error(ErrorCode::Io, fmt::format("{}: cannot read at byte {}: {}", name_, offset,
                                               std::generic_category().message(errno)));
      if (n == 0)
        throw Error(ErrorCode::Corrupt,
                    fmt::format("{}: ends at byte {}: rebuild the store", name_, offset));
      offset += static_cast<std::uint64_t>(n);
      out = out.subspan(static_cast<std::size_t>(n));
    }
  }

  void drop_os_cache() const override { ::posix_fadvise(fd_, 0, 0, POSIX_FADV_DONTNEED); }

 private:
  int fd_;
  std::uint64_t size_;
  std::string name_;
};

class MappedFile : public File {
 public:
  MappedFile(int fd, std::span<std::byte> bytes, std::string name)
      : fd_(fd), bytes_(bytes), name_(std::move(name)) {}
  ~MappedFile() override {
    if (!bytes_.empty()) ::munmap(bytes_.data(), bytes_.size());
    ::close(fd_);
  }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::uint64_t size() const override { return bytes_.size(); }

  void read_at(std::uint64_t offset, std::span<std::byte> out) const override {
    if (offset > bytes_.size() || out.size() > bytes_.size() - offset)
      throw Error(ErrorCode::Corrupt,
                  fmt::format("{}: ends at byte {}: rebuild the store", name_, bytes_.size()));
    std::ranges::copy(bytes_.subspan(offset, out.size()), out.begin());
  }

  // The system keeps what is mapped, whatever it is advised: so that goes first.
  void drop_os_cache() const override {
    if (!bytes_.empty()) ::madvise(bytes_.data(), bytes_.size(), MADV_DONTNEED);
    ::posix_fadvise(fd_, 0, 0, POSIX_FADV_DONTNEED);
  }

 private:
  int fd_;  // for drop_os_cache alone
  std::span<std::byte> bytes_;
  std::string name_;
};

// The descriptor of a regular file and its size.
std::pair<int, std::uint64_t> open_regular(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0)
    throw Error(
        errno == ENOENT || errno == ENOTDIR ? ErrorCode::NotFound : ErrorCode::Io,
        fmt::format("{}: cannot open: {}", path.string(), std::generic_category().message(errno)));
  struct stat status {};
  if (::fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(fd);
    throw Error(ErrorCode::Io, fmt::format("{}: not a regular file", path.string()));
  }
  return {fd, static_cast<std::uint64_t>(status.st_size)};
}

}  // namespace

std::unique_ptr<File> open_file(const std::filesystem::path& path) {
  const auto [fd, size] = open_regular(path);
  return std::make_unique<PosixFile>(fd, size, path.string());
}

std::unique_ptr<File> map_file(const std::filesystem::path& path) {
  const auto [fd, size] = open_regular(path);
  void* at = size > 0 ? ::mmap(nullptr, size, PROT_READ, MAP_SHARED, fd, 0) : nullptr;
  if (at == MAP_FAILED) {
    const int failure = errno;
    ::close(fd);
    throw Error(ErrorCode::Io, fmt::format("{}: cannot map: {}", path.string(),
                                           std::generic_category().message(failure)));
  }
  return std::make_unique<MappedFile>(fd, std::span(static_cast<std::byte*>(at), size),
                                      path.string());
}

}  // namespace arete::store
