#pragma once

#include <filesystem>
#include <vector>

namespace arete::app {

/// Files and directories that are being made; those not finished are removed at the end of the
/// scope, newest first, so that a failure leaves nothing at -o.
class Unfinished {
 public:
  Unfinished() = default;
  ~Unfinished();
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;

  void add(std::filesystem::path path) { paths_.push_back(std::move(path)); }
  /// Makes the directory unless it is there. Throws: InvalidInput when it holds anything.
  void add_directory(const std::filesystem::path& directory);
  void finish() { paths_.clear(); }

 private:
  std::vector<std::filesystem::path> paths_;
};

}  // namespace arete::app
