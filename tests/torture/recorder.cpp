#include "torture/recorder.h"

#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstdio>
#include <mutex>
#include <optional>
#include <utility>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace arete::torture {
namespace {

namespace fs = std::filesystem;
using Kind = FileOp::Kind;

struct Recording {
  std::mutex mutex;
  std::string root;  // empty: nothing is recorded
  std::vector<FileOp> ops;
  bool can_exchange = true;
};

Recording& recording() {
  static Recording the;
  return the;
}

// The function that this program's own definition hides.
template <typename Function>
Function* hidden(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

std::optional<std::string> below_root(const std::string& path) {
  const std::string& root = recording().root;
  if (root.empty() || !path.starts_with(root)) return std::nullopt;
  if (path.size() == root.size()) return std::string();
  if (path[root.size()] != '/') return std::nullopt;
  return fs::path(path.substr(root.size() + 1)).lexically_normal().string();
}

std::string path_of(int fd) {
  char path[PATH_MAX];
  const auto link = "/proc/self/fd/" + std::to_string(fd);
  const ssize_t n = ::readlink(link.c_str(), path, sizeof path);
  return n > 0 ? std::string(path, static_cast<std::size_t>(n)) : std::string();
}

void note(Kind kind, const std::string& path, const std::string& other = {},
          std::uint64_t offset = 0, Bytes bytes = {}) {
  Recording& r = recording();
  const int saved = errno;
  const std::scoped_lock lock(r.mutex);
  if (const auto place = below_root(path))
    r.ops.push_back({kind, *place, below_root(other).value_or(""), offset, std::move(bytes)});
  errno = saved;
}

int note_if_done(int result, Kind kind, const std::string& path, const std::string& other = {}) {
  if (result == 0) note(kind, path, other);
  return result;
}

int open_noting(const char* path, int flags, mode_t mode) {
  struct stat status {};
  const bool is_new = (flags & O_CREAT) != 0 && ::stat(path, &status) != 0;
  const int fd = hidden<int(const char*, int, ...)>("open")(path, flags, mode);
  if (fd >= 0 && is_new) note(Kind::Create, path);
  return fd;
}

}  // namespace

std::vector<FileOp> record(const fs::path& folder, const std::function<void()>& work) {
  Recording& r = recording();
  r.root = folder.string();
  work();
  r.root.clear();
  return std::exchange(r.ops, {});
}

void without_exchange(const std::function<void()>& work) {
  struct Refusal {
    Refusal() { recording().can_exchange = false; }
    ~Refusal() { recording().can_exchange = true; }
    Refusal(const Refusal&) = delete;
    Refusal& operator=(const Refusal&) = delete;
  };
  const Refusal refusal;
  work();
}

}  // namespace arete::torture

// Everything below stands before the C library's function of the same name, for this program and
// the shared libraries that it uses.
using namespace arete::torture;

extern "C" {

int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  return open_noting(path, flags, mode);
}

ssize_t pwrite(int fd, const void* data, size_t bytes, off_t offset) {
  const ssize_t n =
      hidden<ssize_t(int, const void*, size_t, off_t)>("pwrite")(fd, data, bytes, offset);
  const char* from = static_cast<const char*>(data);
  if (n > 0)
    note(Kind::Write, path_of(fd), {}, static_cast<std::uint64_t>(offset), Bytes(from, from + n));
  return n;
}

int posix_fallocate(int fd, off_t offset, off_t bytes) {
  const int result = hidden<int(int, off_t, off_t)>("posix_fallocate")(fd, offset, bytes);
  if (result == 0)
    note(Kind::Allocate, path_of(fd), {}, static_cast<std::uint64_t>(offset + bytes));
  return result;
}

int fsync(int fd) {
  return note_if_done(hidden<int(int)>("fsync")(fd), Kind::Sync, path_of(fd));
}

int rename(const char* from, const char* to) noexcept {
  const int result = hidden<int(const char*, const char*)>("rename")(from, to);
  return note_if_done(result, Kind::Rename, from, to);
}

int renameat2(int from_fd, const char* from, int to_fd, const char* to,
              unsigned int flags) noexcept {
  const bool swaps = (flags & RENAME_EXCHANGE) != 0;
  if (swaps && !recording().can_exchange) {
    errno = EINVAL;
    return -1;
  }
  const int result = hidden<int(int, const char*, int, const char*, unsigned int)>("renameat2")(
      from_fd, from, to_fd, to, flags);
  return note_if_done(result, swaps ? Kind::Exchange : Kind::Rename, from, to);
}

int link(const char* from, const char* to) noexcept {
  const int result = hidden<int(const char*, const char*)>("link")(from, to);
  return note_if_done(result, Kind::Link, from, to);
}

int mkdir(const char* path, mode_t mode) noexcept {
  const int result = hidden<int(const char*, mode_t)>("mkdir")(path, mode);
  return note_if_done(result, Kind::MakeDirectory, path);
}

int unlink(const char* path) noexcept {
  return note_if_done(hidden<int(const char*)>("unlink")(path), Kind::Remove, path);
}

int rmdir(const char* path) noexcept {
  return note_if_done(hidden<int(const char*)>("rmdir")(path), Kind::Remove, path);
}

int remove(const char* path) noexcept {
  return note_if_done(hidden<int(const char*)>("remove")(path), Kind::Remove, path);
}

int unlinkat(int folder, const char* name, int flags) noexcept {
  const std::string path =
      name[0] == '/' || folder == AT_FDCWD ? std::string(name) : path_of(folder) + "/" + name;
  return note_if_done(hidden<int(int, const char*, int)>("unlinkat")(folder, name, flags),
                      Kind::Remove, path);
}

}  // extern "C"
