#include "arete/lod/bintree/page_thread.h"

#include <utility>

namespace arete::lod::bintree {

PageThread::PageThread(std::function<void(PageRead&)> read)
    : read_(std::move(read)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

void PageThread::add(const PageRead& read) {
  {
    const std::scoped_lock lock(mutex_);
    if (2 * next_ >= waiting_.size()) drop_begun();  // the queue never outgrows twice what waits
    waiting_.push_back(read);
  }
  more_.notify_one();
}

void PageThread::take_waiting(std::vector<PageRead>& out) {
  out.clear();
  const std::scoped_lock lock(mutex_);
  drop_begun();
  waiting_.swap(out);
}

void PageThread::take_finished(std::vector<PageRead>& out) {
  out.clear();
  const std::scoped_lock lock(mutex_);
  finished_.swap(out);
}

void PageThread::await_finished(std::vector<PageRead>& out) {
  out.clear();
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return !reading_; });
  finished_.swap(out);
}

void PageThread::drop_begun() {
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(next_));
  next_ = 0;
}

void PageThread::run(const std::stop_token& stop) {
  while (true) {
    PageRead read;
    {
      std::unique_lock lock(mutex_);
      if (!more_.wait(lock, stop, [this] { return next_ < waiting_.size(); })) return;
      if (stop.stop_requested()) return;
      read = waiting_[next_++];
      reading_ = true;
    }
    read_(read);
    {
      const std::scoped_lock lock(mutex_);
      finished_.push_back(read);
      reading_ = false;
    }
    idle_.notify_one();
  }
}

}  // namespace arete::lod::bintree
