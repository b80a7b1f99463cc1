#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "arete/core/post.h"

namespace arete {

/// Names a block of vertices or indices of one engine; unique for the engine's life. A block is
/// immutable but for what a list's uploads name.
using BlockKey = std::uint64_t;
/// The draw list's own arrays, which change every frame.
inline constexpr BlockKey kOwnBlock = 0;

inline constexpr int kFactorCount = 13;

/// One vertex format for every method; 32 bytes.
/// drawn z = z + sum_k dz[k] * factor[slot[k]]; drawn plan = post + (dcol, drow) * factor[slot[0]].
/// Slots >= kFactorCount read a factor of 0.
struct Vertex {
  Post post;
  float z = 0;                ///< metres at factor 0
  std::array<float, 3> dz{};  ///< metres
  std::int16_t dcol = 0, drow = 0;
  std::array<std::uint8_t, 4> slot{255, 255, 255, 255};
};
static_assert(sizeof(Vertex) == 32);

/// How a batch's indices form triangles. Strips join with degenerate triangles, which draw nothing.
enum class Topology : std::uint8_t { Triangles, Strip };

struct DrawBatch {
  BlockKey vertices = kOwnBlock, indices = kOwnBlock;
  std::uint32_t first_index = 0, index_count = 0;
  std::array<float, kFactorCount> factor{};  ///< geomorph factors, 0..1
  float error = 0;                           ///< bound on |drawn z - true z| over the batch, metres
  Topology topology = Topology::Triangles;
};

/// What one refine did; every figure is of that frame alone.
struct RefineStats {
  std::uint64_t triangles = 0;           ///< drawn, degenerate ones not counted
  std::uint64_t visited_nodes = 0;       ///< tiles or tree nodes looked at
  std::uint64_t evaluated_vertices = 0;  ///< errors projected
  std::uint64_t culled = 0;              ///< tiles or subtrees found outside the frustum
  std::uint64_t late_blocks = 0;         ///< wanted but drawn coarser: missing, damaged or deferred
  std::uint64_t pages_touched = 0;       ///< record pages looked into (bin-trees)
  std::uint64_t pages_read = 0;          ///< of those, read in this frame, which waited for them
  std::uint64_t page_bytes = 0;          ///< of record pages held or being read (bin-trees)
  std::uint64_t built_blocks = 0;        ///< vertex blocks made in this frame
  std::uint64_t bytes_built = 0;         ///< bytes of those blocks: what of vertices is to upload
  std::uint64_t resident_bytes = 0;      ///< vertex blocks that the engine holds
  std::uint64_t full_triangles = 0;      ///< what full resolution would draw in the same places
  double achieved_error_px = 0;          ///< bound over everything drawn; 0 when nothing is
  /// The tolerance that the frame keeps: the one asked for, or a larger one where a budget asked
  /// for it (`full`: 0 until then); infinite when no bound in pixels is left.
  double tolerance_px = 0;
};

enum class BlockKind : std::uint8_t { Vertices, Indices };

/// Blocks that do change. Vertices: [first, first + count), appended since the last frame.
/// Indices: the block, [0, count), which is of this frame alone.
struct Upload {
  BlockKey block = kOwnBlock;
  std::uint32_t first = 0, count = 0;
  BlockKind kind = BlockKind::Vertices;
};

/// Everything an engine says to the world about one frame. Cleared, never reallocated after
/// warm-up.
struct DrawList {
  std::vector<DrawBatch> batches;
  std::vector<Vertex> vertices;        ///< block kOwnBlock
  std::vector<std::uint32_t> indices;  ///< block kOwnBlock; local to the batch's vertex block
  std::vector<Upload> uploads;
  RefineStats stats;
  void clear();
};

/// Gives the contents of the blocks that a DrawList names. Spans hold until that engine's next
/// refine. Requires: a key named by the engine's latest list.
class BlockSource {
 public:
  virtual ~BlockSource() = default;
  virtual std::span<const Vertex> vertices(BlockKey key) const = 0;
  virtual std::span<const std::uint32_t> indices(BlockKey key) const = 0;
};

/// Height of the vertex under the batch's factors: the reference that the vertex stage must equal.
float morphed_z(const Vertex& v, const std::array<float, kFactorCount>& factor);

}  // namespace arete
