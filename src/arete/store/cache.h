#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <unordered_set>

namespace arete::store {

/// Names a block: a segment of the store and a key in it.
struct BlockName {
  std::uint32_t segment = 0;
  std::uint64_t key = 0;
  friend bool operator==(const BlockName&, const BlockName&) = default;
};

struct BlockNameHash {
  std::size_t operator()(const BlockName& n) const {
    return (n.key * 0x9E3779B97F4A7C15U) ^ (std::size_t{n.segment} << 48U);
  }
};

using BlockSet = std::unordered_set<BlockName, BlockNameHash>;

/// Least-recently-used cache of decoded blocks under a hard byte budget: room is made before a
/// block enters, so the bytes held never exceed it. Thread contract: safe from several threads.
class BlockCache {
 public:
  explicit BlockCache(std::size_t budget_bytes) : budget_(budget_bytes) {}
  /// Null when it is not here.
  std::shared_ptr<const void> find(const BlockName& name);
  bool contains(const BlockName& name) const;
  /// Keeps the block unless it alone exceeds the budget. When another thread was first, its block
  /// stays and is returned.
  std::shared_ptr<const void> insert(const BlockName& name, std::shared_ptr<const void> block,
                                     std::size_t bytes);
  std::size_t resident_bytes() const;
  std::size_t resident_bytes_max() const;

 private:
  struct Entry {
    BlockName name;
    std::shared_ptr<const void> block;
    std::size_t bytes = 0;
  };
  mutable std::mutex mutex_;
  std::size_t budget_, resident_ = 0, resident_max_ = 0;
  std::list<Entry> by_age_;  ///< most recent first
  std::unordered_map<BlockName, std::list<Entry>::iterator, BlockNameHash> by_name_;
};

}  // namespace arete::store
