#include "arete/store/output_file.h"

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "arete/core/error.h"

namespace arete::store {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const char* what, int reason) {
  const char* remedy = reason == ENOSPC || reason == EDQUOT || reason == EFBIG
                           ? ": free disk space or choose another output"
                           : "";
  throw Error(ErrorCode::Io, fmt::format("{}: cannot {}: {}{}", path.string(), what,
                                         std::generic_category().message(reason), remedy));
}

int open_or_fail(const std::filesystem::path& path, int flags) {
  const int fd = ::open(path.c_str(), flags | O_CLOEXEC, 0666);
  if (fd < 0) fail(path, "open", errno);
  return fd;
}

void sync_path(const std::filesystem::path& path, int flags) {
  const int fd = open_or_fail(path, flags);
  const int result = ::fsync(fd);
  const int reason = errno;
  ::close(fd);
  if (result != 0) fail(path, "sync", reason);
}

}  // namespace

OutputFile::OutputFile(std::filesystem::path path) : path_(std::move(path)), temporary_(path_) {
  temporary_ += ".tmp";
  ::unlink(temporary_.c_str());
  fd_ = open_or_fail(temporary_, O_RDWR | O_CREAT | O_EXCL);
}

OutputFile::~OutputFile() {
  if (fd_ < 0) return;
  ::close(fd_);
  ::unlink(temporary_.c_str());
}

void OutputFile::allocate(std::uint64_t bytes) {
  if (bytes == 0) return;
  int reason = 0;
  do {
    reason = ::posix_fallocate(fd_, 0, static_cast<off_t>(bytes));
  } while (reason == EINTR);
  if (reason != 0) fail(path_, "reserve space", reason);
}

void OutputFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail(path_, "write", n == 0 ? EIO : errno);
    offset += static_cast<std::uint64_t>(n);
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
}

void OutputFile::start_writeback() {
  ::sync_file_range(fd_, 0, 0, SYNC_FILE_RANGE_WRITE);
}

void OutputFile::sync() {
  if (::fsync(fd_) != 0) fail(path_, "sync", errno);
}

void OutputFile::publish() {
  const int fd = std::exchange(fd_, -1);
  const bool closed = ::close(fd) == 0;
  if (!closed || ::rename(temporary_.c_str(), path_.c_str()) != 0) {
    const int reason = errno;
    ::unlink(temporary_.c_str());
    fail(path_, closed ? "rename" : "close", reason);
  }
}

void sync_file(const std::filesystem::path& file) {
  sync_path(file, O_RDONLY);
}

void sync_directory(const std::filesystem::path& directory) {
  sync_path(directory, O_RDONLY | O_DIRECTORY);
}

void sync_parent(const std::filesystem::path& path) {
  sync_directory(path.has_parent_path() ? path.parent_path() : std::filesystem::path("."));
}

void write_file_durably(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  {
    OutputFile file(path);
    file.allocate(bytes.size());
    file.write_at(0, bytes);
    file.sync();
    file.publish();
  }
  sync_parent(path);
}

}  // namespace arete::store
