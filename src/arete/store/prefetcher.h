#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "arete/store/cache.h"

namespace arete::store {

/// One thread that loads blocks ahead of their use: first what the last replace() asked for, in
/// its order, then missed blocks. Thread contract: safe from several threads.
class Prefetcher {
 public:
  /// `load` is called on the thread and must not throw.
  explicit Prefetcher(std::function<void(const BlockName&)> load);
  Prefetcher(const Prefetcher&) = delete;
  Prefetcher& operator=(const Prefetcher&) = delete;
  ~Prefetcher() = default;

  /// Most wanted first; what was asked before and has not been begun is dropped.
  void replace(std::vector<BlockName> wanted);
  /// Asks for one block that was needed and not there. Beyond kMaxMissed waiting ones it is
  /// dropped.
  void add_missed(const BlockName& name);

 private:
  static constexpr std::size_t kMaxMissed = 4096;
  void run(const std::stop_token& stop);
  bool take(const std::stop_token& stop, BlockName& name);

  std::function<void(const BlockName&)> load_;
  std::mutex mutex_;
  std::condition_variable_any more_;
  std::vector<BlockName> wanted_, missed_;
  std::size_t next_wanted_ = 0;
  BlockSet waiting_;     ///< what missed_ holds
  std::jthread thread_;  ///< last: it stops before the members that it uses go
};

}  // namespace arete::store
