#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "arete/lod/bintree/page_thread.h"
#include "arete/lod/bintree/record.h"
#include "arete/lod/bintree/vertex_index.h"
#include "arete/lod/engine.h"
#include "arete/store/terrain.h"

namespace arete::lod::bintree {

/// Records a page: 4 KiB of consecutive indices.
inline constexpr int kLog2PageRecords = 9;
inline constexpr std::size_t kPageRecords = std::size_t{1} << kLog2PageRecords;
inline constexpr std::size_t kRecordPageBytes = kPageRecords * sizeof(Record);

/// How the delta of a vertex is measured (METHODS 1.4).
enum class Delta {
  Exact,        ///< over all posts of the two triangles: a bound
  Incremental,  ///< at the vertex alone, as the papers do: no bound
};
/// "bintree" or "bintree-incremental".
std::string bintree_segment(Delta delta);

/// Whether pages are read ahead of their use. What a deferred find() missed is read in either case.
enum class Prefetch { On, Off };

/// What RecordPages did. The first three are of the current frame, the others since opening.
struct PageCounts {
  std::uint64_t touched = 0;  ///< different stored pages that find() returned records of
  std::uint64_t faults = 0;   ///< pages read by find()
  std::uint64_t late = 0;     ///< find() that returned null
  std::uint64_t bytes_read = 0;
  std::uint64_t prefetched = 0;  ///< pages that the thread has read
  std::uint64_t damaged = 0;     ///< pages that failed verification; they are not read again
  /// Of pages here or in the thread's hands: within the budget.
  std::uint64_t resident_bytes = 0, resident_bytes_max = 0;
};

/// The records of a terrain, read in pages through the store's verification under a hard byte
/// budget. Thread contract: one thread at a time; the thread that reads pages is its own affair.
class RecordPages {
 public:
  struct Options {
    Delta delta = Delta::Exact;
    std::size_t budget_bytes = std::size_t{256} << 20U;  ///< of pages; at least one is held
    Prefetch prefetch = Prefetch::On;
  };
  /// Memory beside the budget: 16 bytes for each 4 KiB of index space near a stored page.
  /// Throws: NotFound when the store lacks the segment (naming the command that adds it), Corrupt,
  /// Limit for a terrain beyond Domain::kMaxLog2Cells. `terrain` must outlive it.
  RecordPages(const store::Terrain& terrain, const Options& options);
  ~RecordPages();
  RecordPages(const RecordPages&) = delete;
  RecordPages& operator=(const RecordPages&) = delete;

  const Domain& domain() const { return domain_; }
  /// The largest finite delta of the vertices of a depth, metres (METHODS 8.6).
  double delta_max(int depth) const { return delta_max_[static_cast<std::size_t>(depth)]; }

  /// Starts a frame: pages that the thread has read come in, and pointers from before may dangle.
  void begin_frame();
  /// The vertex's record; holds until the next begin_frame. Null when the page is damaged, not
  /// resident under Defer (the thread is asked for it), or the budget is full of pages touched in
  /// this frame; under Wait the thread gives its pages back first.
  /// Requires: index < domain().index_end(). Cost: a few ns for a resident page. Throws: nothing.
  const Record* find(VertexIndex index, OnMissing on_missing) {
    const std::uint64_t page = index >> kLog2PageRecords;
    Entry& entry = leaves_[page >> kLog2LeafPages][page & (kLeafPages - 1)];
    if (entry.frame != frame_) [[unlikely]]
      if (!touch(entry, on_missing)) return nullptr;
    return entry.records + (index & (kPageRecords - 1));
  }
  /// True when no find() on the page need wait: it is here, or nothing is stored of it. A damaged
  /// one counts as here: it will not come.
  bool holds(std::uint64_t page) {
    const Entry& entry = entry_of(page);
    return entry.records != nullptr || entry.key == kDamaged;
  }
  /// Page number of an index, for ask().
  static std::uint64_t page_of(VertexIndex index) { return index >> kLog2PageRecords; }
  /// Asks the thread for the pages that this frame missed and then, unless Prefetch::Off, for those
  /// that later ones may need; most wanted first. Replaces what was asked before. They come in at
  /// the next begin_frame after they are read.
  void ask(std::span<const std::uint64_t> missing, std::span<const std::uint64_t> ahead);

  const PageCounts& counts() const { return counts_; }
  /// Memory held from opening on: the budget's pages, as many as are stored, and what finds them.
  std::uint64_t table_bytes() const;

 private:
  /// A page of the index space.
  struct Entry {
    const Record* records = nullptr;
    std::uint32_t frame = 0;  ///< the last one that touched it
    std::int32_t key = kNoKey;
  };
  static constexpr std::int32_t kNoKey = -1, kDamaged = -2;
  static constexpr int kLog2LeafPages = 10;
  static constexpr std::size_t kLeafPages = std::size_t{1} << kLog2LeafPages;
  using Leaf = std::array<Entry, kLeafPages>;

  void require_fit(bool fits) const;
  void index_pages();
  void read_maxima();
  Entry& entry_of(std::uint64_t page) {
    return leaves_[page >> kLog2LeafPages][page & (kLeafPages - 1)];
  }
  bool touch(Entry& entry, OnMissing on_missing);
  bool load(Entry& entry);
  void ask(std::span<const std::uint64_t> pages);
  void ask(Entry& entry);
  void take_waiting();
  void take_from_thread();
  void take_in(const PageRead& read);
  void note_damage(Entry& entry);
  std::size_t read_page(std::size_t key, Record* to) const;
  std::size_t most_asked() const;
  Record* take_slot();
  Entry** oldest_holder();
  void hold(Record* records, Entry& entry, std::uint32_t frame);
  void count_resident();

  const store::Terrain& terrain_;
  std::string segment_;
  std::span<const std::uint64_t> keys_;
  Domain domain_;
  std::uint32_t frame_ = 1;
  std::vector<Entry*> leaves_;
  std::vector<std::unique_ptr<Leaf>> leaf_memory_;
  std::unique_ptr<Leaf> empty_leaf_;  ///< stands wherever no page is stored
  std::vector<double> delta_max_;
  PageCounts counts_;

  std::size_t slots_ = 0, fresh_ = 0, hand_ = 0;  ///< fresh_: slots never used begin here
  std::unique_ptr<Record[]> memory_;
  std::vector<Record*> free_;
  std::vector<Entry*> holders_;      ///< by slot; null: free, or the thread's
  std::vector<std::uint8_t> asked_;  ///< by key: the thread has it
  std::size_t asked_count_ = 0;
  Prefetch prefetch_;
  std::vector<PageRead> taken_;  ///< from the thread; here for its memory
  PageThread thread_;            ///< last: it stops before what it uses goes
};

}  // namespace arete::lod::bintree
