#include "arete/store/cache.h"

#include <algorithm>

namespace arete::store {

std::shared_ptr<const void> BlockCache::find(const BlockName& name) {
  const std::scoped_lock lock(mutex_);
  const auto found = by_name_.find(name);
  if (found == by_name_.end()) return nullptr;
  by_age_.splice(by_age_.begin(), by_age_, found->second);
  return found->second->block;
}

bool BlockCache::contains(const BlockName& name) const {
  const std::scoped_lock lock(mutex_);
  return by_name_.contains(name);
}

std::shared_ptr<const void> BlockCache::insert(const BlockName& name,
                                               std::shared_ptr<const void> block,
                                               std::size_t bytes) {
  std::list<Entry> evicted;  // freed after the lock is given back
  const std::scoped_lock lock(mutex_);
  const auto found = by_name_.find(name);
  if (found != by_name_.end()) return found->second->block;
  if (bytes > budget_) return block;
  while (resident_ + bytes > budget_) {
    resident_ -= by_age_.back().bytes;
    by_name_.erase(by_age_.back().name);
    evicted.splice(evicted.end(), by_age_, std::prev(by_age_.end()));
  }
  by_age_.push_front({name, block, bytes});
  by_name_.emplace(name, by_age_.begin());
  resident_ += bytes;
  resident_max_ = std::max(resident_max_, resident_);
  return block;
}

std::size_t BlockCache::resident_bytes() const {
  const std::scoped_lock lock(mutex_);
  return resident_;
}

std::size_t BlockCache::resident_bytes_max() const {
  const std::scoped_lock lock(mutex_);
  return resident_max_;
}

}  // namespace arete::store
