#include "arete/store/file.h"

#include <cerrno>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <fmt/format.h>
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
                                               std::strerror(errno)));
      if (n == 0)
        throw Error(ErrorCode::Corrupt,
                    fmt::format("{}: ends at byte {}: rebuild the store", name_, offset));
      offset += static_cast<std::uint64_t>(n);
      out = out.subspan(static_cast<std::size_t>(n));
    }
  }

 private:
  int fd_;
  std::uint64_t size_;
  std::string name_;
};

}  // namespace

std::unique_ptr<File> open_file(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0)
    throw Error(errno == ENOENT || errno == ENOTDIR ? ErrorCode::NotFound : ErrorCode::Io,
                fmt::format("{}: cannot open: {}", path.string(), std::strerror(errno)));
  struct stat status {};
  if (::fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(fd);
    throw Error(ErrorCode::Io, fmt::format("{}: not a regular file", path.string()));
  }
  return std::make_unique<PosixFile>(fd, static_cast<std::uint64_t>(status.st_size), path.string());
}

}  // namespace arete::store
