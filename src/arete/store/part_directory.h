#pragma once

#include <filesystem>
#include <string>

namespace arete::store {

/// NAME.arete.part beside the output: what a running build keeps, and what a killed one left.
///   lock     held by flock while a build runs
///   key      names source and options; another key empties the directory
///   units/   finished pieces of segments
///   store/   the store to be, published by one rename
class PartDirectory {
 public:
  /// Creates or takes over the directory. Throws: Io, also when another build holds it.
  PartDirectory(const std::filesystem::path& output, const std::string& key);
  /// Gives the lock back; the directory stays.
  ~PartDirectory();
  PartDirectory(const PartDirectory&) = delete;
  PartDirectory& operator=(const PartDirectory&) = delete;

  std::filesystem::path units() const { return path_ / "units"; }
  std::filesystem::path store() const { return path_ / "store"; }
  std::filesystem::path retired() const { return path_ / "retired"; }
  /// Makes sure that no later build goes on from here: once the new store is about to take the old
  /// one's place, what lies here may be the old store. Throws: Io.
  void forget_key();
  /// Deletes the directory and all in it; errors are left to the next build.
  void remove() noexcept;

 private:
  void lock();
  void prepare(const std::string& key);
  std::filesystem::path path_;
  int lock_fd_ = -1;
};

}  // namespace arete::store
