#include "arete/store/segment_writer.h"

#include <cassert>

#include "arete/store/bytes.h"

namespace arete::store {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20U;

// A block goes to the next aligned byte if it touches no more pages there than it must, else it
// begins a page: small blocks share pages, and no read meets a page more than necessary.
std::uint64_t place(std::uint64_t at, std::uint64_t bytes) {
  const std::uint64_t packed = (at + kBlockAlign - 1) / kBlockAlign * kBlockAlign;
  const std::uint64_t pages_packed = page_ceil(packed % kPageBytes + bytes);
  return pages_packed <= page_ceil(bytes) ? packed : page_ceil(at);
}

// Over keys and raw content, so that it does not depend on the compressor's version.
Hash128 content_id(const SegmentHeader& header, const std::string& params,
                   const std::vector<BlockEntry>& entries) {
  std::vector<std::byte> bytes;
  ByteWriter writer(bytes);
  writer.bytes(std::as_bytes(std::span(header.name)));
  writer(std::uint8_t{0});
  writer(std::uint64_t{params.size()});
  writer.bytes(std::as_bytes(std::span(params)));
  for (const BlockEntry& e : entries) {
    writer(e.key);
    writer(e.raw_bytes);
    writer(e.raw_hash);
  }
  return hash128(bytes);
}

}  // namespace

SegmentWriter::SegmentWriter(const std::filesystem::path& path, std::string name,
                             std::string params, std::vector<BlockEntry> entries)
    : file_(path), params_(std::move(params)), entries_(std::move(entries)) {
  assert(params_.size() <= kMaxParamsBytes);
  header_.name = std::move(name);
  std::uint64_t end = kPageBytes;
  for (BlockEntry& e : entries_) {
    e.offset = place(end, e.stored_bytes);
    end = e.offset + e.stored_bytes;
  }
  header_.params_offset = page_ceil(end);
  header_.params_bytes = params_.size();
  header_.directory_offset = header_.params_offset + page_ceil(params_.size());
  header_.block_count = entries_.size();
  header_.page_table_offset = header_.directory_offset + page_ceil(entries_.size() * kEntryBytes);
  const std::uint64_t pages = header_.page_table_offset / kPageBytes;
  header_.file_bytes =
      header_.page_table_offset + page_ceil(pages * sizeof(std::uint64_t)) + kPageBytes;
  header_.id = content_id(header_, params_, entries_);
  file_.allocate(header_.file_bytes);
  page_table_.reserve(pages);
  put(encode_header(header_));
}

void SegmentWriter::append(std::span<const std::byte> stored) {
  const BlockEntry& e = entries_[next_entry_++];
  assert(stored.size() == e.stored_bytes);
  pad_to(e.offset);
  put(stored);
}

SegmentRecord SegmentWriter::finish() {
  assert(next_entry_ == entries_.size());
  pad_to(header_.params_offset);
  put(std::as_bytes(std::span(params_)));
  pad_to(header_.directory_offset);
  std::vector<std::byte> directory;
  for (const BlockEntry& e : entries_) append_entry(e, directory);
  put(directory);
  pad_to(header_.page_table_offset);
  flush();

  const auto words = std::as_bytes(std::span(page_table_));
  std::vector<std::byte> table(words.begin(), words.end());
  table.resize(page_ceil(table.size()));
  SegmentFooter footer;
  footer.file_bytes = header_.file_bytes;
  footer.page_table_offset = header_.page_table_offset;
  footer.page_table_hash = hash64(table);
  footer.header_hash = own_hash(encode_header(header_));
  file_.write_at(header_.page_table_offset, table);
  file_.write_at(header_.file_bytes - kPageBytes, encode_footer(footer));
  file_.start_writeback();
  file_.publish();
  return {header_.name, header_.id.hex(), header_.file_bytes};
}

void SegmentWriter::put(std::span<const std::byte> bytes) {
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  if (buffer_.size() >= kBufferBytes) flush();
}

void SegmentWriter::pad_to(std::uint64_t offset) {
  buffer_.resize(offset - flushed_);
}

void SegmentWriter::flush() {
  const std::size_t whole = buffer_.size() / kPageBytes * kPageBytes;
  const auto pages = std::span(buffer_).first(whole);
  for (std::size_t at = 0; at < whole; at += kPageBytes)
    page_table_.push_back(hash64(pages.subspan(at, kPageBytes), page_table_.size()));
  file_.write_at(flushed_, pages);
  flushed_ += whole;
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(whole));
}

}  // namespace arete::store
