#include "arete/store/unit.h"

#include <algorithm>
#include <cassert>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/store/block_codec.h"
#include "arete/store/bytes.h"

namespace arete::store {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20U;
constexpr std::size_t kTrailerBytes = 4 * sizeof(std::uint64_t);

struct Trailer {
  std::uint64_t unit_key = 0, block_count = 0, aux_bytes = 0;
  std::uint64_t hash = 0;  // of every byte before it
};

template <typename Io, typename T>
void trailer_fields(Io& io, T& t) {
  io(t.unit_key);
  io(t.block_count);
  io(t.aux_bytes);
  io(t.hash);
}

}  // namespace

UnitWriter::UnitWriter(const std::filesystem::path& file, std::uint64_t unit_key)
    : file_(file), unit_key_(unit_key) {}

void UnitWriter::add(std::uint64_t key, std::span<const std::byte> raw) {
  assert(raw.size() <= kMaxBlockBytes);
  assert(entries_.empty() || entries_.back().key < key);
  BlockEntry e;
  e.key = key;
  e.offset = flushed_ + buffer_.size();
  e.raw_bytes = static_cast<std::uint32_t>(raw.size());
  e.raw_hash = hash64(raw);
  e.stored_bytes = static_cast<std::uint32_t>(compress_block(raw, buffer_));
  entries_.push_back(e);
  if (buffer_.size() >= kBufferBytes) flush();
}

void UnitWriter::finish() {
  ByteWriter writer(buffer_);
  writer.bytes(aux_);
  for (const BlockEntry& e : entries_) append_entry(e, buffer_);
  Trailer trailer{unit_key_, entries_.size(), aux_.size(), 0};
  writer(trailer.unit_key);
  writer(trailer.block_count);
  writer(trailer.aux_bytes);
  flush();
  writer(hasher_.digest());
  flush();
  file_.publish();
}

void UnitWriter::flush() {
  hasher_.add(buffer_);
  file_.write_at(flushed_, buffer_);
  flushed_ += buffer_.size();
  buffer_.clear();
}

UnitReader::UnitReader(const std::filesystem::path& file)
    : file_(open_file(file)), file_name_(file.string()) {}

std::unique_ptr<UnitReader> UnitReader::open(const std::filesystem::path& file,
                                             std::uint64_t unit_key, Trust trust) {
  if (!std::filesystem::exists(file)) return nullptr;
  std::unique_ptr<UnitReader> unit(new UnitReader(file));
  return unit->read_index(unit_key, trust) ? std::move(unit) : nullptr;
}

bool UnitReader::read_index(std::uint64_t unit_key, Trust trust) {
  const std::uint64_t size = file_->size();
  if (size < kTrailerBytes) return false;
  std::array<std::byte, kTrailerBytes> bytes;
  file_->read_at(size - kTrailerBytes, bytes);
  ByteReader reader(bytes);
  Trailer t;
  trailer_fields(reader, t);
  if (t.unit_key != unit_key) return false;
  if (trust == Trust::Verify && t.hash != hash_of_file(size - sizeof t.hash)) return false;
  const std::uint64_t index_bytes = t.block_count * kEntryBytes;
  std::vector<std::byte> index(index_bytes);
  file_->read_at(size - kTrailerBytes - index_bytes, index);
  aux_.resize(t.aux_bytes);
  file_->read_at(size - kTrailerBytes - index_bytes - t.aux_bytes, aux_);
  for (std::size_t i = 0; i < t.block_count; ++i)
    entries_.push_back(decode_entry(std::span(index).subspan(i * kEntryBytes, kEntryBytes)));
  return true;
}

std::uint64_t UnitReader::hash_of_file(std::uint64_t bytes) const {
  Hasher hasher;
  std::vector<std::byte> buffer(std::min<std::uint64_t>(bytes, kBufferBytes));
  for (std::uint64_t at = 0; at < bytes; at += buffer.size()) {
    buffer.resize(std::min<std::uint64_t>(bytes - at, kBufferBytes));
    file_->read_at(at, buffer);
    hasher.add(buffer);
  }
  return hasher.digest();
}

bool UnitReader::read(std::uint64_t key, std::vector<std::byte>& raw) const {
  const auto found = std::ranges::lower_bound(entries_, key, {}, &BlockEntry::key);
  if (found == entries_.end() || found->key != key) return false;
  thread_local std::vector<std::byte> stored;
  read_stored(static_cast<std::size_t>(found - entries_.begin()), stored);
  raw.resize(found->raw_bytes);
  if (!decompress_block(stored, raw) || hash64(raw) != found->raw_hash)
    throw Error(ErrorCode::Corrupt, file_name_ + ": a finished unit changed: build again");
  return true;
}

void UnitReader::read_stored(std::size_t i, std::vector<std::byte>& stored) const {
  stored.resize(entries_[i].stored_bytes);
  file_->read_at(entries_[i].offset, stored);
}

UnitFolder::UnitFolder(std::filesystem::path folder, std::string name, const std::string& content)
    : folder_(std::move(folder)), name_(std::move(name)), content_hash_(hash64(content)) {}

bool UnitFolder::is_finished(int unit) const {
  return UnitReader::open(path(unit), key(unit), UnitReader::Trust::Verify) != nullptr;
}

std::unique_ptr<UnitReader> UnitFolder::open(int unit) const {
  auto reader = UnitReader::open(path(unit), key(unit), UnitReader::Trust::ThisRun);
  if (!reader)
    throw Error(ErrorCode::Corrupt, path(unit).string() + ": a finished unit changed: build again");
  return reader;
}

void UnitFolder::make(int unit, const std::function<void(UnitWriter&)>& fill) const {
  if (is_finished(unit)) return;
  UnitWriter writer(path(unit), key(unit));
  fill(writer);
  writer.finish();
}

void UnitFolder::clear() const {
  for (const auto& entry : std::filesystem::directory_iterator(folder_))
    if (entry.path().filename().string().starts_with(name_ + "."))
      std::filesystem::remove(entry.path());
}

std::filesystem::path UnitFolder::path(int unit) const {
  return folder_ / fmt::format("{}.{}.unit", name_, unit);
}

std::uint64_t UnitFolder::key(int unit) const {
  return hash64(fmt::format("{}\n{:016x}\n{}", name_, content_hash_, unit));
}

}  // namespace arete::store
