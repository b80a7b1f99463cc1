#include "arete/store/part_directory.h"

#include <cerrno>
#include <system_error>
#include <vector>

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

// 0 or the reason why not.
int try_to_lock(int fd) {
  int result = 0;
  do {
    result = ::flock(fd, LOCK_EX | LOCK_NB);
  } while (result != 0 && errno == EINTR);
  return result == 0 ? 0 : errno;
}

std::string read_text(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return {};
  const auto file = open_file(path);
  std::string text(file->size(), '\0');
  file->read_at(0, std::as_writable_bytes(std::span(text)));
  return text;
}

fs::path part_path(const fs::path& output) {
  fs::path path = output.has_filename() ? output : output.parent_path();
  path += ".part";
  return path;
}

}  // namespace

std::optional<fs::path> retired_store(const fs::path& output) {
  std::error_code error;
  const fs::path retired = part_path(output) / "retired";
  if (fs::exists(output, error) || !fs::exists(retired, error)) return std::nullopt;
  return retired;
}

void bring_back_store(const fs::path& output) {
  if (!retired_store(output)) return;
  PartDirectory part(output);
  part.bring_back();
  part.remove();
}

PartDirectory::PartDirectory(const fs::path& output) : output_(output), path_(part_path(output)) {
  lock();
}

PartDirectory::PartDirectory(const fs::path& output, const std::string& key)
    : PartDirectory(output) {
  try {
    bring_back();
    prepare(key);
  } catch (...) {
    remove();
    throw;
  }
}

PartDirectory::~PartDirectory() {
  ::close(lock_fd_);
}

void PartDirectory::bring_back() const {
  const auto old = retired_store(output_);
  if (!old) return;
  if (::rename(old->c_str(), output_.c_str()) != 0)
    throw Error(ErrorCode::Io,
                fmt::format("{}: cannot bring back the old store from {}: {}", output_.string(),
                            old->string(), std::generic_category().message(errno)));
  sync_parent(output_);
}

void PartDirectory::prepare(const std::string& key) {
  try {
    if (read_text(path_ / "key") != key) {
      for (const fs::path& part : {units(), store(), retired()}) fs::remove_all(part);
      write_file_durably(path_ / "key", std::as_bytes(std::span(key)));
    }
    fs::remove_all(retired());
    fs::create_directories(units());
    fs::create_directories(store());
  } catch (const fs::filesystem_error& e) {
    throw Error(ErrorCode::Io,
                fmt::format("{}: cannot prepare: {}", path_.string(), e.code().message()));
  }
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
    if (fd < 0) {
      const int reason = errno;
      fs::remove(path_, error);  // only if it is empty
      throw Error(ErrorCode::Io,
                  fmt::format("{}: cannot create: {}: choose an output that can be written",
                              path_.string(), std::generic_category().message(reason)));
    }
    if (const int reason = try_to_lock(fd); reason != 0) {
      ::close(fd);
      if (reason == EWOULDBLOCK)
        throw Error(ErrorCode::Io,
                    fmt::format("{}: another build is running: wait for it", path_.string()));
      throw Error(ErrorCode::Io,
                  fmt::format("{}: cannot lock: {}: choose another file system", path_.string(),
                              std::generic_category().message(reason)));
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
    throw Error(ErrorCode::Io, fmt::format("{}: cannot remove: {}", key.string(),
                                           std::generic_category().message(errno)));
  sync_directory(path_);
}

// The lock goes last: with it gone another build may begin here, and then nothing of it must be
// deleted. What that build has put into the directory keeps the directory; so does an old store
// that cannot go back.
void PartDirectory::remove() noexcept {
  try {
    bring_back();
  } catch (const std::exception&) {
    if (retired_store(output_)) return;
  }
  std::error_code error;
  std::vector<fs::path> all;
  for (fs::directory_iterator it(path_, error), end; !error && it != end; it.increment(error))
    if (it->path().filename() != "lock") all.push_back(it->path());
  for (const fs::path& path : all) fs::remove_all(path, error);
  fs::remove(path_ / "lock", error);
  fs::remove(path_, error);
}

}  // namespace arete::store
