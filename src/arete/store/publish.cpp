#include "arete/store/publish.h"

#include <cerrno>
#include <cstdio>
#include <functional>
#include <system_error>

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
    throw Error(ErrorCode::Io, fmt::format("{}: cannot publish: {}", to.string(),
                                           std::generic_category().message(errno)));
}

// What undoes the publication: the old store, if there was one, is at `output` again.
using Undo = std::function<void()>;

// The old store must not move into a directory that a power cut takes away.
Undo move_aside_and_in(const fs::path& from, const fs::path& output, const fs::path& retired) {
  sync_parent(retired.parent_path());
  rename_or_fail(output, retired);
  try {
    rename_or_fail(from, output);
  } catch (const Error&) {
    rename_or_fail(retired, output);
    throw;
  }
  return [=] {
    rename_or_fail(output, from);
    rename_or_fail(retired, output);
  };
}

Undo put_in_place(const fs::path& from, const fs::path& output, const fs::path& retired) {
  if (!fs::exists(output)) {
    rename_or_fail(from, output);
    return [=] { rename_or_fail(output, from); };
  }
  if (exchange(from, output)) return [=] { exchange(from, output); };
  return move_aside_and_in(from, output, retired);
}

}  // namespace

void publish_directory(const fs::path& from, const fs::path& output, const fs::path& retired) {
  const Undo undo = put_in_place(from, output, retired);
  try {
    sync_parent(output);
  } catch (const Error&) {
    undo();
    throw;
  }
}

}  // namespace arete::store
