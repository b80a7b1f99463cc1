#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/render/gl_object.h"
#include "arete/render/range_allocator.h"

namespace arete::render {

/// A block of one engine: keys of different engines, and of vertices and indices, may coincide.
struct BlockName {
  const BlockSource* source = nullptr;
  BlockKey key = kOwnBlock;
  BlockKind kind = BlockKind::Vertices;
  friend bool operator==(const BlockName&, const BlockName&) = default;
};

/// One GL buffer that holds everything a frame reads: immutable blocks, uploaded once and evicted
/// least recently used first, and streams that live one frame. Never larger than the cap.
/// Offsets are bytes, multiples of kGranule, and hold until the next begin_frame.
class BlockArena {
 public:
  static constexpr std::uint64_t kGranule = sizeof(Vertex);

  /// Throws: Limit when the driver has not even the first part.
  explicit BlockArena(std::uint64_t cap_bytes);
  /// Gives the streams of the frame before back. Blocks not found or added since may be evicted.
  void begin_frame();
  /// Offset of a block that is held; marks it as used in this frame.
  std::optional<std::uint64_t> find(const BlockName& name);
  /// Uploads a block, with room for `spare` more bytes, growing the buffer and evicting as needed.
  /// Empty when it does not fit. Requires: not held.
  std::optional<std::uint64_t> add(const BlockName& name, std::span<const std::byte> bytes,
                                   std::uint64_t spare = 0);
  /// Uploads bytes [first, first + count) of a held block's new contents, and whatever was appended
  /// before them in frames that were not drawn. A block that outgrew its room is dropped, to be
  /// added again. Does nothing when it is not held.
  void update(const BlockName& name, std::span<const std::byte> bytes, std::uint64_t first,
              std::uint64_t count);
  /// Room for this frame only, aligned to `alignment` bytes; empty when it does not fit.
  std::optional<std::uint64_t> reserve(std::uint64_t bytes, std::uint64_t alignment = kGranule);
  void write(std::uint64_t offset, std::span<const std::byte> bytes);
  /// Drops every block of the source, or all when it is null.
  void forget(const BlockSource* source);
  /// Drops everything, the frame's streams too: what is added next lies without gaps.
  void clear();

  GLuint buffer() const { return buffer_.get(); }
  std::uint64_t capacity() const { return allocator_.size() * kGranule; }
  std::uint64_t cap() const { return cap_granules_ * kGranule; }
  std::uint64_t bytes_held() const { return allocator_.taken() * kGranule; }
  std::uint64_t bytes_uploaded() const { return bytes_uploaded_; }  ///< since begin_frame

 private:
  struct Block {
    BlockName name;
    std::uint64_t first, granules;
    std::uint64_t frame;  // last use
    std::uint64_t bytes;  // uploaded
  };
  struct NameHash {
    std::size_t operator()(const BlockName& n) const;
  };
  struct Stream {
    std::uint64_t first, granules;
  };
  using Blocks = std::list<Block>;  // least recently used first

  bool make_room(std::uint64_t granules);
  bool grow(std::uint64_t granules);
  bool evict_oldest();
  void drop(Blocks::iterator block);
  void give_streams();
  bool allocate(std::uint64_t bytes);

  std::uint64_t cap_granules_;
  RangeAllocator allocator_;
  GlBuffer buffer_;
  Blocks blocks_;
  std::unordered_map<BlockName, Blocks::iterator, NameHash> by_name_;
  std::vector<Stream> streams_;
  std::uint64_t frame_ = 1, bytes_uploaded_ = 0;
};

}  // namespace arete::render
