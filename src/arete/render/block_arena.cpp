#include "arete/render/block_arena.h"

#include <algorithm>
#include <cassert>
#include <functional>

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::render {
namespace {

constexpr std::uint64_t kFirstBytes = std::uint64_t{32} << 20U;

std::uint64_t granules_of(std::uint64_t bytes) {
  return std::max<std::uint64_t>(1, (bytes + BlockArena::kGranule - 1) / BlockArena::kGranule);
}

}  // namespace

std::size_t BlockArena::NameHash::operator()(const BlockName& n) const {
  std::uint64_t h = n.key * 0x9E3779B97F4A7C15U;
  h ^= std::hash<const void*>()(n.source) + (h >> 29U);
  return static_cast<std::size_t>(h * 2 + static_cast<std::uint64_t>(n.kind));
}

BlockArena::BlockArena(std::uint64_t cap_bytes)
    : cap_granules_(cap_bytes / kGranule),
      allocator_(std::min(cap_granules_, kFirstBytes / kGranule)) {
  if (allocate(capacity())) return;
  throw Error(ErrorCode::Limit,
              fmt::format("GPU memory: the driver refuses {} bytes: close other programs that use "
                          "the GPU or allow less",
                          capacity()));
}

// False when the driver has no memory for it.
bool BlockArena::allocate(std::uint64_t bytes) {
  while (glGetError() != GL_NO_ERROR) {
  }
  buffer_.reset();
  buffer_ = make_buffer();
  glNamedBufferStorage(buffer_.get(), static_cast<GLsizeiptr>(bytes), nullptr,
                       GL_DYNAMIC_STORAGE_BIT);
  return glGetError() == GL_NO_ERROR;
}

void BlockArena::begin_frame() {
  give_streams();
  bytes_uploaded_ = 0;
  ++frame_;
}

void BlockArena::give_streams() {
  for (const Stream& s : streams_) allocator_.give(s.first, s.granules);
  streams_.clear();
}

std::optional<std::uint64_t> BlockArena::find(const BlockName& name) {
  const auto found = by_name_.find(name);
  if (found == by_name_.end()) return std::nullopt;
  const auto block = found->second;
  block->frame = frame_;
  blocks_.splice(blocks_.end(), blocks_, block);
  return block->first * kGranule;
}

std::optional<std::uint64_t> BlockArena::add(const BlockName& name,
                                             std::span<const std::byte> bytes,
                                             std::uint64_t spare) {
  assert(!by_name_.contains(name));
  const std::uint64_t granules = granules_of(bytes.size() + spare);
  std::optional<std::uint64_t> first = allocator_.take(granules);
  while (!first && make_room(granules)) first = allocator_.take(granules);
  if (!first) return std::nullopt;
  blocks_.push_back({name, *first, granules, frame_, bytes.size()});
  by_name_.emplace(name, std::prev(blocks_.end()));
  write(*first * kGranule, bytes);
  return *first * kGranule;
}

void BlockArena::update(const BlockName& name, std::span<const std::byte> bytes,
                        std::uint64_t first, std::uint64_t count) {
  const auto found = by_name_.find(name);
  if (found == by_name_.end()) return;
  const auto block = found->second;
  if (granules_of(bytes.size()) > block->granules) {
    drop(block);
  } else if (first + count <= bytes.size()) {
    const std::uint64_t from = std::min(first, block->bytes);
    write(block->first * kGranule + from, bytes.subspan(from, first + count - from));
    block->bytes = std::max(block->bytes, first + count);
  }
}

std::optional<std::uint64_t> BlockArena::reserve(std::uint64_t bytes, std::uint64_t alignment) {
  const std::uint64_t slack = alignment > kGranule ? alignment - kGranule : 0;
  const std::uint64_t granules = granules_of(bytes + slack);
  std::optional<std::uint64_t> first = allocator_.take_last(granules);
  while (!first && make_room(granules)) first = allocator_.take_last(granules);
  if (!first) return std::nullopt;
  streams_.push_back({*first, granules});
  return (*first * kGranule + alignment - 1) / alignment * alignment;
}

void BlockArena::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  glNamedBufferSubData(buffer_.get(), static_cast<GLintptr>(offset),
                       static_cast<GLsizeiptr>(bytes.size()), bytes.data());
  bytes_uploaded_ += bytes.size();
}

void BlockArena::forget(const BlockSource* source) {
  for (auto block = blocks_.begin(); block != blocks_.end();) {
    const auto next = std::next(block);
    if (source == nullptr || block->name.source == source) drop(block);
    block = next;
  }
}

void BlockArena::clear() {
  forget(nullptr);
  give_streams();
}

bool BlockArena::make_room(std::uint64_t granules) {
  return grow(granules) || evict_oldest();
}

// Through the CPU, because the old and the new buffer together could exceed the cap. Happens a
// handful of times in a renderer's life.
bool BlockArena::grow(std::uint64_t granules) {
  if (allocator_.size() >= cap_granules_) return false;
  const std::uint64_t old_bytes = capacity();
  std::vector<std::byte> kept(old_bytes);
  glGetNamedBufferSubData(buffer_.get(), 0, static_cast<GLsizeiptr>(old_bytes), kept.data());
  const std::uint64_t wish = std::min(cap_granules_, allocator_.size() * 2 + granules);
  const bool grown = allocate(wish * kGranule);
  if (grown) {
    allocator_.grow(wish);
  } else {
    cap_granules_ = allocator_.size();  // what the driver gave before is the cap from now on
    allocate(old_bytes);
  }
  glNamedBufferSubData(buffer_.get(), 0, static_cast<GLsizeiptr>(old_bytes), kept.data());
  return grown;
}

bool BlockArena::evict_oldest() {
  if (blocks_.empty() || blocks_.front().frame == frame_) return false;
  drop(blocks_.begin());
  return true;
}

void BlockArena::drop(Blocks::iterator block) {
  allocator_.give(block->first, block->granules);
  by_name_.erase(block->name);
  blocks_.erase(block);
}

}  // namespace arete::render
