#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "arete/lod/bintree/record.h"

namespace arete::lod::bintree {

/// A page to read: where it stands in the segment, and memory that is the thread's until the page
/// is given back.
struct PageRead {
  std::size_t key = 0;
  Record* to = nullptr;
  std::size_t bytes_read = 0;  ///< from the file; 0 = damaged
};

/// One thread that reads pages while frames are drawn. Thread contract: one other thread uses it.
class PageThread {
 public:
  /// `read` fills read.to and sets read.bytes_read; it is called on the thread and must not throw.
  explicit PageThread(std::function<void(PageRead&)> read);
  PageThread(const PageThread&) = delete;
  PageThread& operator=(const PageThread&) = delete;
  ~PageThread() = default;

  /// Adds a read behind those that wait.
  void add(const PageRead& read);
  /// Takes back the reads that have not begun, the finished ones. What `out` held goes; memory
  /// changes hands, so none is allocated once the most that ever waited has waited.
  void take_waiting(std::vector<PageRead>& out);
  void take_finished(std::vector<PageRead>& out);
  /// take_finished once the read that has begun, if one has, is finished, too.
  void await_finished(std::vector<PageRead>& out);

 private:
  void run(const std::stop_token& stop);
  void drop_begun();

  std::function<void(PageRead&)> read_;
  std::mutex mutex_;
  std::condition_variable_any more_, idle_;
  std::vector<PageRead> waiting_, finished_;
  std::size_t next_ = 0;  ///< in waiting_
  bool reading_ = false;
  std::jthread thread_;  ///< last: it stops before the members that it uses go
};

}  // namespace arete::lod::bintree
