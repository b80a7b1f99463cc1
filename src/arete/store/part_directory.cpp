#include "arete/store/part_directory.h"

#include <cerrno>
#include <cstring>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "arete/core/error.h"
#include "arete/store/file.h"
#include "arete/store/output_file.h"

namespace arete::store {
namespace {

namespace fs = std::filesystem;

bool same_file(int fd, const fs::path& path) {
  struct stat held {};
  struct stat named {};
  return ::fstat(fd, &held) == 0 && ::stat(path.c_str(), &named) == 0 &&
         held.st_ino == named.st_ino && held.st_dev == named.st_dev;
}

std::string read_text(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return {};
  const auto file = open_file(path);
  std::string text(file->size(), '\0');
  file->read_at(0, std::as_writable_bytes(std::span(text)));
  return text;
}

}  // namespace

PartDirectory::PartDirectory(const fs::path& output, const std::string& key) : path_(output) {
  path_ += ".part";
  lock();
  try {
    if (read_text(path_ / "key") != key) {
      for (const fs::path& part : {units(), store(), retired()}) fs::remove_all(part);
      write_file_durably(path_ / "key", std::as_bytes(std::span(key)));
    }
    fs::remove_all(retired());
    fs::create_directories(units());
    fs::create_directories(store());
  } catch (const fs::filesystem_error& e) {
    ::close(lock_fd_);
    throw Error(ErrorCode::Io,
                fmt::format("{}: cannot prepare: {}", path_.string(), e.code().message()));
  }
}

PartDirectory::~PartDirectory() {
  if (lock_fd_ >= 0) ::close(lock_fd_);
}

// The holder may delete the directory between our open and our flock: then the lock is on a file
// that no name leads to, and is taken anew.
void PartDirectory::lock() {
  const fs::path file = path_ / "lock";
  while (true) {
    std::error_code error;
    fs::create_directories(path_, error);
    const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (fd < 0 && errno == ENOENT && !error) continue;
    if (fd < 0)
      throw Error(ErrorCode::Io,
                  fmt::format("{}: cannot create: {}", path_.string(), std::strerror(errno)));
    if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
      ::close(fd);
      throw Error(ErrorCode::Io,
                  fmt::format("{}: another build is running: wait for it", path_.string()));
    }
    if (same_file(fd, file)) {
      lock_fd_ = fd;
      return;
    }
    ::close(fd);
  }
}

void PartDirectory::forget_key() {
  const fs::path key = path_ / "key";
  if (::unlink(key.c_str()) != 0)
    throw Error(ErrorCode::Io,
                fmt::format("{}: cannot remove: {}", key.string(), std::strerror(errno)));
  sync_directory(path_);
}

void PartDirectory::remove() noexcept {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace arete::store
