#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace arete::torture {

using Bytes = std::vector<char>;
/// Files by their path relative to a folder.
using Files = std::map<std::string, Bytes>;

/// One successful system call that changed, or made durable, something below a folder. Paths are
/// relative to that folder; "" is the folder itself.
struct FileOp {
  enum class Kind { Create, Write, Allocate, Sync, MakeDirectory, Remove, Rename, Exchange, Link };
  Kind kind;
  std::string path, other;   ///< other: where Rename, Exchange and Link lead to
  std::uint64_t offset = 0;  ///< of Write; bytes of Allocate
  Bytes bytes = {};          ///< of Write
};

/// Runs `work` and notes, in order, what this process does to the file system below `folder`. It
/// sees the calls themselves (this program stands before the C library), so the code under test
/// has no seam for it. One recording at a time. Requires: an absolute path without symbolic links.
std::vector<FileOp> record(const std::filesystem::path& folder, const std::function<void()>& work);
/// Runs `work` as on a file system that cannot exchange two names.
void without_exchange(const std::function<void()>& work);

}  // namespace arete::torture
