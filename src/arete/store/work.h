#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <string>
#include <thread>

#include "arete/core/build_context.h"

namespace arete::store {

/// Reports a step's progress and turns the caller's "no" into Cancelled.
/// Thread contract: add() from any thread; the callback is called on the constructing thread only.
class StepProgress {
 public:
  StepProgress(const BuildContext& context, std::string step, int total);
  /// One more of `total` is done. Throws: Cancelled.
  void add_one();

 private:
  void report() const;
  const BuildContext& context_;
  std::string step_;
  int total_;
  std::atomic<int> done_{0};
  std::thread::id caller_ = std::this_thread::get_id();
};

/// Calls body(i) for i in [0, count) in parallel with progress; as many threads as the context
/// has and as fit half its memory limit with `bytes_each`. Throws: Cancelled, what body throws.
void for_each_unit(const BuildContext& context, const std::string& step, int count,
                   std::size_t bytes_each, const std::function<void(int)>& body);

/// As many as the context has and as fit half its memory limit; at least 1.
int threads_within(const BuildContext& context, std::size_t bytes_each);

}  // namespace arete::store
