#include "arete/lod/bintree/page_thread.h"

#include <utility>

namespace arete::lod::bintree {

PageThread::PageThread(std::function<void(PageRead&)> read)
    : read_(std::move(read)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

void PageThread::add(const PageRead& read) {
  {
    const std::scoped_lock lock(mutex_);
    waiting_.push_back(read);
  }
  more_.notify_one();
}

std::vector<PageRead> PageThread::take_waiting() {
  const std::scoped_lock lock(mutex_);
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(next_));
  next_ = 0;
  return std::exchange(waiting_, {});
}

std::vector<PageRead> PageThread::take_finished() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(finished_, {});
}

void PageThread::run(const std::stop_token& stop) {
  while (true) {
    PageRead read;
    {
      std::unique_lock lock(mutex_);
      if (!more_.wait(lock, stop, [this] { return next_ < waiting_.size(); })) return;
      if (stop.stop_requested()) return;
      read = waiting_[next_++];
      if (next_ == waiting_.size()) {  // all taken: the queue never outgrows what waits
        waiting_.clear();
        next_ = 0;
      }
    }
    read_(read);
    const std::scoped_lock lock(mutex_);
    finished_.push_back(read);
  }
}

}  // namespace arete::lod::bintree
