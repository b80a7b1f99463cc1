#include "arete/lod/bintree/record_pages.h"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/lod/bintree/page_codec.h"
#include "arete/lod/bintree/page_layout.h"

namespace arete::lod::bintree {
namespace {

constexpr std::array<Record, kPageRecords> kZeroPage{};
// Pages looked at for the one to give up.
constexpr std::size_t kCandidates = 16;
// The thread holds at most this share of the budget, but one page of the least.
constexpr std::size_t kAheadShare = 4;

Domain domain_of(const store::Terrain& terrain) {
  const store::Manifest& m = terrain.manifest();
  if (!Domain::fits(m.cols, m.rows))
    throw Error(ErrorCode::Limit,
                fmt::format("{}: {} x {} posts: soar and smart take at most {} a side: use "
                            "geomipmap",
                            terrain.name(), m.cols, m.rows, (1 << Domain::kMaxLog2Cells) + 1));
  return Domain::over(m.cols, m.rows);
}

void require_segment(const store::Terrain& terrain, const std::string& segment, Delta delta) {
  if (!terrain.has_segment(segment))
    throw Error(ErrorCode::NotFound,
                fmt::format("{}: has no segment \"{}\": add it with arete build --methods soar{}",
                            terrain.name(), segment,
                            delta == Delta::Exact ? "" : " --set delta=incremental"));
}

}  // namespace

std::string bintree_segment(Delta delta) {
  return delta == Delta::Exact ? "bintree" : "bintree-incremental";
}

RecordPages::RecordPages(const store::Terrain& terrain, const Options& options)
    : terrain_(terrain),
      segment_(bintree_segment(options.delta)),
      domain_(domain_of(terrain)),
      prefetch_(options.prefetch),
      thread_([this](PageRead& read) { read.bytes_read = read_page(read.key, read.to); }) {
  require_segment(terrain, segment_, options.delta);
  keys_ = terrain.keys(segment_);
  read_maxima();
  index_pages();
  const std::size_t fit = std::max<std::size_t>(options.budget_bytes / kRecordPageBytes, 1);
  slots_ = std::min(fit, std::max<std::size_t>(keys_.size(), 1));
  memory_ = std::make_unique_for_overwrite<Record[]>(slots_ * kPageRecords);
  holders_.resize(slots_, nullptr);
  asked_.resize(keys_.size(), 0);
}

RecordPages::~RecordPages() = default;

void RecordPages::require_fit(bool fits) const {
  if (!fits)
    throw Error(ErrorCode::Corrupt,
                fmt::format("{}: {}.seg does not fit this terrain: build it again with --force",
                            terrain_.name(), segment_));
}

// The last block holds the largest deltas of all depths.
void RecordPages::read_maxima() {
  std::vector<std::byte> raw;
  std::vector<Code> codes(static_cast<std::size_t>(domain_.depths()));
  const bool last = !keys_.empty() && page_of_key(keys_.back()) == kMaximaPage;
  if (last) terrain_.read_block(segment_, keys_.back(), raw);
  require_fit(raw.size() == codes.size() * sizeof(Code));
  std::memcpy(codes.data(), raw.data(), raw.size());
  std::ranges::transform(codes, std::back_inserter(delta_max_),
                         [](Code code) { return static_cast<double>(value(code)); });
}

std::uint64_t RecordPages::table_bytes() const {
  return slots_ * kRecordPageBytes + leaf_memory_.size() * sizeof(Leaf) +
         leaves_.size() * sizeof leaves_[0] + holders_.size() * sizeof holders_[0] + asked_.size();
}

void RecordPages::index_pages() {
  empty_leaf_ = std::make_unique<Leaf>();
  empty_leaf_->fill({kZeroPage.data(), 0, kNoKey});
  const std::uint64_t pages = page_of(domain_.index_end() - 1) + 1;
  leaves_.assign((pages - 1) / kLeafPages + 1, empty_leaf_->data());
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const std::uint64_t page = page_of_key(keys_[i]);
    if (page == kMaximaPage) continue;
    require_fit(page < pages);
    Entry*& leaf = leaves_[page >> kLog2LeafPages];
    if (leaf == empty_leaf_->data()) {
      leaf_memory_.push_back(std::make_unique<Leaf>(*empty_leaf_));
      leaf = leaf_memory_.back()->data();
    }
    entry_of(page) = {nullptr, 0, static_cast<std::int32_t>(i)};
  }
}

void RecordPages::begin_frame() {
  ++frame_;
  counts_.touched = counts_.faults = counts_.late = 0;
  thread_.take_finished(taken_);
  for (const PageRead& read : taken_) take_in(read);
  count_resident();
}

void RecordPages::take_in(const PageRead& read) {
  asked_[read.key] = 0;
  --asked_count_;
  Entry& entry = entry_of(page_of_key(keys_[read.key]));
  counts_.bytes_read += read.bytes_read;
  if (read.bytes_read > 0) ++counts_.prefetched;
  if (read.bytes_read > 0 && entry.records == nullptr) return hold(read.to, entry, frame_ - 1);
  free_.push_back(read.to);
  // Without records find() was not faster, so nobody knows the damage yet, or find() met it, too.
  if (read.bytes_read == 0 && entry.records == nullptr) note_damage(entry);
}

void RecordPages::note_damage(Entry& entry) {
  if (entry.key == kDamaged) return;
  entry.key = kDamaged;
  ++counts_.damaged;
}

bool RecordPages::touch(Entry& entry, OnMissing on_missing) {
  if (entry.key == kNoKey) {
    entry.frame = frame_;
    return true;
  }
  if (entry.records == nullptr) {
    const bool wait = on_missing == OnMissing::Wait && entry.key != kDamaged;
    if (!wait && entry.key != kDamaged) ask(entry);
    if (!wait || !load(entry)) {
      ++counts_.late;
      return false;
    }
  }
  entry.frame = frame_;
  ++counts_.touched;
  return true;
}

bool RecordPages::load(Entry& entry) {
  Record* slot = take_slot();
  if (slot == nullptr && asked_count_ > 0) {
    take_from_thread();
    if (entry.records != nullptr) return true;  // the thread had just read it
    if (entry.key == kDamaged) return false;
    slot = take_slot();
  }
  if (slot == nullptr) return false;
  const std::size_t bytes = read_page(static_cast<std::size_t>(entry.key), slot);
  if (bytes == 0) {
    free_.push_back(slot);
    note_damage(entry);
    return false;
  }
  counts_.bytes_read += bytes;
  ++counts_.faults;
  hold(slot, entry, frame_);
  count_resident();
  return true;
}

std::size_t RecordPages::read_page(std::size_t key, Record* to) const {
  try {
    thread_local std::vector<std::byte> raw;
    const std::size_t bytes = terrain_.read_block(segment_, keys_[key], raw);
    return decode_page(raw, {to, kPageRecords}) ? bytes : 0;
  } catch (const std::exception&) {
    return 0;
  }
}

void RecordPages::ask(std::span<const std::uint64_t> missing,
                      std::span<const std::uint64_t> ahead) {
  take_waiting();
  ask(missing);
  if (prefetch_ == Prefetch::On) ask(ahead);
}

void RecordPages::take_waiting() {
  thread_.take_waiting(taken_);
  for (const PageRead& read : taken_) {
    asked_[read.key] = 0;
    --asked_count_;
    free_.push_back(read.to);
  }
}

// Every slot that the thread has. What it has read comes in as of the last frame, so may go again.
void RecordPages::take_from_thread() {
  take_waiting();
  thread_.await_finished(taken_);
  for (const PageRead& read : taken_) take_in(read);
}

void RecordPages::ask(std::span<const std::uint64_t> pages) {
  for (const std::uint64_t page : pages) {
    Entry& entry = entry_of(page);
    if (entry.records == nullptr && entry.key >= 0) ask(entry);
  }
}

void RecordPages::ask(Entry& entry) {
  const auto key = static_cast<std::size_t>(entry.key);
  if (asked_[key] != 0 || asked_count_ >= most_asked()) return;
  Record* slot = take_slot();
  if (slot == nullptr) return;
  asked_[key] = 1;
  ++asked_count_;
  thread_.add({key, slot});
  count_resident();
}

std::size_t RecordPages::most_asked() const {
  return std::max<std::size_t>(slots_ / kAheadShare, 1);
}

Record* RecordPages::take_slot() {
  if (!free_.empty()) {
    Record* slot = free_.back();
    free_.pop_back();
    return slot;
  }
  if (fresh_ < slots_) return &memory_[fresh_++ * kPageRecords];
  Entry** holder = oldest_holder();
  if (holder == nullptr) return nullptr;
  const auto slot = static_cast<std::size_t>(holder - holders_.data());
  (*holder)->records = nullptr;
  *holder = nullptr;
  return &memory_[slot * kPageRecords];
}

// Of the next pages about the hand the one that was touched longest ago: nearly the oldest of all,
// without a list that every touch would have to mend. Null: all are of this frame.
RecordPages::Entry** RecordPages::oldest_holder() {
  if (counts_.touched + asked_count_ >= slots_) return nullptr;
  Entry** oldest = nullptr;
  for (std::size_t seen = 0; seen < slots_; ++seen, hand_ = (hand_ + 1) % slots_) {
    Entry*& entry = holders_[hand_];
    if (entry != nullptr && entry->frame != frame_ &&
        (oldest == nullptr || entry->frame < (*oldest)->frame))
      oldest = &entry;
    if (seen >= kCandidates && oldest != nullptr) break;
  }
  return oldest;
}

void RecordPages::hold(Record* records, Entry& entry, std::uint32_t frame) {
  entry.records = records;
  entry.frame = frame;
  holders_[static_cast<std::size_t>(records - memory_.get()) / kPageRecords] = &entry;
}

void RecordPages::count_resident() {
  counts_.resident_bytes = (fresh_ - free_.size()) * kRecordPageBytes;
  counts_.resident_bytes_max = std::max(counts_.resident_bytes_max, counts_.resident_bytes);
}

}  // namespace arete::lod::bintree
