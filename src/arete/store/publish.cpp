#include "arete/store/publish.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/store/output_file.h"

namespace arete::store {
namespace {

namespace fs = std::filesystem;

bool exchange(const fs::path& a, const fs::path& b) {
  return ::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0;
}

void rename_or_fail(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0)
    throw Error(ErrorCode::Io,
                fmt::format("{}: cannot publish: {}", to.string(), std::strerror(errno)));
}

}  // namespace

void publish_directory(const fs::path& from, const fs::path& output, const fs::path& retired) {
  if (!fs::exists(output)) {
    rename_or_fail(from, output);
  } else if (!exchange(from, output)) {
    rename_or_fail(output, retired);
    try {
      rename_or_fail(from, output);
    } catch (const Error&) {
      rename_or_fail(retired, output);
      throw;
    }
  }
  sync_directory(output.has_parent_path() ? output.parent_path() : fs::path("."));
}

}  // namespace arete::store
