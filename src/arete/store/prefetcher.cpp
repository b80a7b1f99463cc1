#include "arete/store/prefetcher.h"

#include <utility>

namespace arete::store {

Prefetcher::Prefetcher(std::function<void(const BlockName&)> load)
    : load_(std::move(load)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

void Prefetcher::replace(std::vector<BlockName> wanted) {
  {
    const std::scoped_lock lock(mutex_);
    wanted_ = std::move(wanted);
    next_wanted_ = 0;
  }
  more_.notify_one();
}

void Prefetcher::add_missed(const BlockName& name) {
  {
    const std::scoped_lock lock(mutex_);
    if (missed_.size() >= kMaxMissed || !waiting_.insert(name).second) return;
    missed_.push_back(name);
  }
  more_.notify_one();
}

void Prefetcher::run(const std::stop_token& stop) {
  BlockName name;
  while (take(stop, name)) load_(name);
}

// Missed blocks go newest first: the older a miss, the likelier that the view has moved on.
bool Prefetcher::take(const std::stop_token& stop, BlockName& name) {
  std::unique_lock lock(mutex_);
  const auto any = [this] { return next_wanted_ < wanted_.size() || !missed_.empty(); };
  if (!more_.wait(lock, stop, any)) return false;
  if (next_wanted_ < wanted_.size()) {
    name = wanted_[next_wanted_++];
    return !stop.stop_requested();
  }
  name = missed_.back();
  missed_.pop_back();
  waiting_.erase(name);
  return !stop.stop_requested();
}

}  // namespace arete::store
