#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace arete::store {

/// NAME.arete.part beside the output: what a running build keeps, and what a killed one left.
///   lock     held by flock while a build runs
///   key      names source and options; another key empties the directory
///   units/   finished pieces of segments
///   store/   the store to be, published by one rename
///   retired/ the old store, where the file system cannot exchange it for the new one in one step
class PartDirectory {
 public:
  /// Creates or takes over the directory, and brings an old store back that a killed build has left
  /// in it. Throws: Io, also when another build holds it.
  PartDirectory(const std::filesystem::path& output, const std::string& key);
  /// Gives the lock back; the directory stays.
  ~PartDirectory();
  PartDirectory(const PartDirectory&) = delete;
  PartDirectory& operator=(const PartDirectory&) = delete;

  const std::filesystem::path& output() const { return output_; }
  std::filesystem::path units() const { return path_ / "units"; }
  std::filesystem::path store() const { return path_ / "store"; }
  std::filesystem::path retired() const { return path_ / "retired"; }
  /// Makes sure that no later build goes on from here: once the new store is about to take the old
  /// one's place, what lies here may be the old store. Throws: Io.
  void forget_key();
  /// Deletes the directory and all in it; errors are left to the next build. An old store without
  /// another name goes back to the output first, or stays.
  void remove() noexcept;

 private:
  friend void bring_back_store(const std::filesystem::path& output);
  explicit PartDirectory(const std::filesystem::path& output);  // only locks it
  void lock();
  void bring_back() const;
  void prepare(const std::string& key);
  std::filesystem::path output_, path_;
  int lock_fd_ = -1;
};

/// Where the old store lies when nothing is at `output` because its replacement was killed between
/// moving the one away and the other in. Throws: nothing.
std::optional<std::filesystem::path> retired_store(const std::filesystem::path& output);
/// Moves it back and deletes the part directory, which holds nothing to go on from: its key went
/// before the old store came. Throws: Io, also when a build is at work there.
void bring_back_store(const std::filesystem::path& output);

}  // namespace arete::store
