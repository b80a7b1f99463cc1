#include "arete/store/segment_reader.h"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/store/block_codec.h"

namespace arete::store {
namespace {

// check_pages reads this many pages at a time.
constexpr std::uint64_t kCheckPages = 256;

[[noreturn]] void fail_corrupt(const std::string& label, const std::string& what) {
  throw Error(ErrorCode::Corrupt, fmt::format("{}: {}: rebuild the store", label, what));
}

Page read_page(const File& file, std::uint64_t offset) {
  Page page;
  file.read_at(offset, page);
  return page;
}

}  // namespace

SegmentReader::SegmentReader(std::unique_ptr<File> file, std::string label, Verify verify)
    : file_(std::move(file)), label_(std::move(label)), verify_(verify) {
  const std::uint64_t size = file_->size();
  if (size < 3 * kPageBytes || size % kPageBytes != 0)
    fail_corrupt(label_, fmt::format("truncated ({} bytes)", size));
  header_ = decode_header(read_page(*file_, 0), size, label_);
  read_page_table();
  read_params_and_directory();
}

void SegmentReader::read_page_table() {
  const Page header_page = read_page(*file_, 0);
  const SegmentFooter footer =
      decode_footer(read_page(*file_, header_.file_bytes - kPageBytes), label_);
  if (footer.file_bytes != header_.file_bytes ||
      footer.page_table_offset != header_.page_table_offset ||
      footer.header_hash != own_hash(header_page))
    fail_corrupt(label_, "header and footer disagree");
  std::vector<std::byte> table(header_.file_bytes - kPageBytes - header_.page_table_offset);
  file_->read_at(header_.page_table_offset, table);
  if (hash64(table) != footer.page_table_hash) fail_corrupt(label_, "the page table is damaged");
  page_table_.resize(header_.page_table_offset / kPageBytes);
  std::memcpy(page_table_.data(), table.data(), page_table_.size() * sizeof(std::uint64_t));
}

void SegmentReader::read_params_and_directory() {
  const auto params = read_verified(header_.params_offset, header_.params_bytes);
  params_.resize(params.size());
  std::ranges::transform(params, params_.begin(), [](std::byte b) { return static_cast<char>(b); });
  const auto bytes = read_verified(header_.directory_offset, header_.block_count * kEntryBytes);
  entries_.resize(header_.block_count);
  keys_.resize(header_.block_count);
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    entries_[i] = decode_entry(std::span(bytes).subspan(i * kEntryBytes, kEntryBytes));
    keys_[i] = entries_[i].key;
    check_entry(i);
  }
}

void SegmentReader::check_entry(std::size_t i) const {
  const BlockEntry& e = entries_[i];
  const bool inside = e.offset >= kPageBytes && e.offset <= header_.params_offset &&
                      e.stored_bytes <= header_.params_offset - e.offset;
  const bool sized = e.raw_bytes <= kMaxBlockBytes && e.stored_bytes <= e.raw_bytes;
  const bool sorted = i == 0 || keys_[i - 1] < e.key;
  if (!inside || !sized || !sorted) fail_corrupt(label_, fmt::format("bad directory entry {}", i));
}

bool SegmentReader::contains(std::uint64_t key) const {
  return std::ranges::binary_search(keys_, key);
}

std::size_t SegmentReader::read(std::uint64_t key, std::vector<std::byte>& raw) const {
  const auto found = std::ranges::lower_bound(keys_, key);
  if (found == keys_.end() || *found != key) return 0;
  const BlockEntry& e = entries_[static_cast<std::size_t>(found - keys_.begin())];
  const std::uint64_t begin = e.offset / kPageBytes * kPageBytes;
  thread_local std::vector<std::byte> pages;
  pages.resize(page_ceil(e.offset + e.stored_bytes) - begin);
  file_->read_at(begin, pages);
  verify_pages(begin / kPageBytes, pages);
  raw.resize(e.raw_bytes);
  const auto stored = std::span(pages).subspan(e.offset - begin, e.stored_bytes);
  if (!decompress_block(stored, raw) || (verify_ == Verify::Pages && hash64(raw) != e.raw_hash))
    fail_corrupt(label_, fmt::format("block {:#x} does not decode", key));
  return std::max<std::size_t>(pages.size(), 1);
}

void SegmentReader::check_pages(std::uint64_t first, std::uint64_t count) const {
  const std::uint64_t end = std::min<std::uint64_t>(first + count, page_table_.size());
  std::vector<std::byte> pages;
  for (std::uint64_t page = first; page < end; page += kCheckPages) {
    pages.resize(std::min(kCheckPages, end - page) * kPageBytes);
    file_->read_at(page * kPageBytes, pages);
    verify_pages(page, pages);
  }
}

void SegmentReader::check_all(const std::function<void(std::uint64_t)>& progress) const {
  for (std::uint64_t page = 0; page < page_table_.size(); page += kCheckPages) {
    check_pages(page, kCheckPages);
    if (progress) progress(std::min<std::uint64_t>(page + kCheckPages, page_table_.size()));
  }
}

std::vector<std::byte> SegmentReader::read_verified(std::uint64_t offset,
                                                    std::uint64_t bytes) const {
  std::vector<std::byte> pages(page_ceil(bytes));
  file_->read_at(offset, pages);
  verify_pages(offset / kPageBytes, pages);
  pages.resize(bytes);
  return pages;
}

void SegmentReader::verify_pages(std::uint64_t first_page, std::span<const std::byte> pages) const {
  if (verify_ == Verify::Nothing) return;
  for (std::size_t i = 0; i * kPageBytes < pages.size(); ++i) {
    const std::uint64_t page = first_page + i;
    if (hash64(pages.subspan(i * kPageBytes, kPageBytes), page) != page_table_[page])
      fail_corrupt(label_, fmt::format("page {} is damaged", page));
  }
}

}  // namespace arete::store
