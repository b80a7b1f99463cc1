#include "arete/store/format.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/store/bytes.h"

namespace arete::store {
namespace {

constexpr std::string_view kHeaderMagic("ARETE\r\n\x1a", 8);
constexpr std::string_view kFooterMagic("ARETEEND", 8);
constexpr std::size_t kHashAt = kPageBytes - sizeof(std::uint64_t);

// One list of fields serves both directions: `io` is a ByteWriter or a ByteReader.
template <typename Io, typename Header>
void header_fields(Io& io, Header& h) {
  io(h.version_major);
  io(h.version_minor);
  std::conditional_t<std::is_const_v<Header>, const std::uint32_t, std::uint32_t> page_bytes =
      kPageBytes;
  io(page_bytes);
  io(h.required_features);
  io(h.optional_features);
  io(h.file_bytes);
  io(h.params_offset);
  io(h.params_bytes);
  io(h.directory_offset);
  io(h.block_count);
  io(h.page_table_offset);
  io(h.id.low);
  io(h.id.high);
}

template <typename Io, typename Footer>
void footer_fields(Io& io, Footer& f) {
  io(f.file_bytes);
  io(f.page_table_offset);
  io(f.page_table_hash);
  io(f.header_hash);
}

template <typename Io, typename Entry>
void entry_fields(Io& io, Entry& e) {
  io(e.key);
  io(e.offset);
  io(e.stored_bytes);
  io(e.raw_bytes);
  io(e.raw_hash);
}

Page seal(const std::vector<std::byte>& bytes) {
  assert(bytes.size() <= kHashAt);
  Page page{};
  std::ranges::copy(bytes, page.begin());
  const std::uint64_t hash = hash64(std::span(page).first(kHashAt));
  std::memcpy(page.data() + kHashAt, &hash, sizeof hash);
  return page;
}

// Checks magic and hash; gives the bytes behind the magic.
ByteReader unseal(const Page& page, std::string_view magic, const std::string& place) {
  if (std::memcmp(page.data(), magic.data(), magic.size()) != 0)
    throw Error(ErrorCode::Corrupt, place + ": not a segment of an Arete store: rebuild the store");
  if (own_hash(page) != hash64(std::span(page).first(kHashAt)))
    throw Error(ErrorCode::Corrupt, place + " is damaged: rebuild the store");
  return ByteReader(std::span(page).first(kHashAt).subspan(magic.size()));
}

void refuse_unknown(const SegmentHeader& h, const std::string& file) {
  if (h.version_major != kVersionMajor)
    throw Error(ErrorCode::Unsupported,
                fmt::format("{}: format version {}, this build reads {}: use a newer arete", file,
                            h.version_major, kVersionMajor));
  const std::uint64_t unknown = h.required_features & ~kKnownRequired;
  if (unknown != 0)
    throw Error(ErrorCode::Unsupported,
                fmt::format("{}: needs unknown features {:#x}: use a newer arete", file, unknown));
}

bool layout_fits(const SegmentHeader& h, std::uint64_t file_bytes) {
  const auto ordered = {std::uint64_t{kPageBytes}, h.params_offset, h.directory_offset,
                        h.page_table_offset, file_bytes};
  const bool whole_pages =
      std::ranges::all_of(ordered, [](std::uint64_t at) { return at % kPageBytes == 0; });
  if (!whole_pages || !std::ranges::is_sorted(ordered) || h.file_bytes != file_bytes) return false;
  const std::uint64_t table_bytes = h.page_table_offset / kPageBytes * sizeof(std::uint64_t);
  return h.params_bytes <= kMaxParamsBytes &&
         h.params_bytes <= h.directory_offset - h.params_offset &&
         h.block_count <= (h.page_table_offset - h.directory_offset) / kEntryBytes &&
         h.page_table_offset + page_ceil(table_bytes) + kPageBytes == file_bytes;
}

}  // namespace

Page encode_header(const SegmentHeader& header) {
  assert(is_segment_name(header.name));
  std::vector<std::byte> bytes;
  ByteWriter writer(bytes);
  writer.bytes(std::as_bytes(std::span(kHeaderMagic)));
  header_fields(writer, header);
  writer.bytes(std::as_bytes(std::span(header.name)));
  return seal(bytes);
}

Page encode_footer(const SegmentFooter& footer) {
  std::vector<std::byte> bytes;
  ByteWriter writer(bytes);
  writer.bytes(std::as_bytes(std::span(kFooterMagic)));
  footer_fields(writer, footer);
  return seal(bytes);
}

SegmentHeader decode_header(const Page& page, std::uint64_t file_bytes, const std::string& file) {
  ByteReader reader = unseal(page, kHeaderMagic, file + ": header");
  SegmentHeader h;
  header_fields(reader, h);
  const auto name = reader.bytes(kNameBytes);
  for (std::size_t i = 0; i < name.size() && name[i] != std::byte{0}; ++i)
    h.name += static_cast<char>(name[i]);
  refuse_unknown(h, file);
  if (!layout_fits(h, file_bytes) || !is_segment_name(h.name))
    throw Error(
        ErrorCode::Corrupt,
        fmt::format("{}: truncated or damaged ({} bytes, header says {}): rebuild the store", file,
                    file_bytes, h.file_bytes));
  return h;
}

SegmentFooter decode_footer(const Page& page, const std::string& file) {
  ByteReader reader = unseal(page, kFooterMagic, file + ": footer");
  SegmentFooter f;
  footer_fields(reader, f);
  return f;
}

std::uint64_t own_hash(const Page& page) {
  std::uint64_t hash = 0;
  std::memcpy(&hash, page.data() + kHashAt, sizeof hash);
  return hash;
}

void append_entry(const BlockEntry& entry, std::vector<std::byte>& out) {
  ByteWriter writer(out);
  entry_fields(writer, entry);
}

BlockEntry decode_entry(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  BlockEntry entry;
  entry_fields(reader, entry);
  return entry;
}

bool is_segment_name(std::string_view name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  };
  return !name.empty() && name.size() < kNameBytes && std::ranges::all_of(name, allowed);
}

}  // namespace arete::store
