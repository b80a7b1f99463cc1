#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/render/block_arena.h"

namespace arete::render {

/// glMultiDrawElementsIndirect's record; base_instance is the draw's row of factors.
struct DrawCommand {
  std::uint32_t count, instances, first_index;
  std::int32_t base_vertex;
  std::uint32_t base_instance;
};
static_assert(sizeof(DrawCommand) == 20);

/// Factors of one draw as the vertex stage reads them.
struct DrawFactors {
  std::array<float, 16> factor;
};

enum class Morph { On, Off };

/// A DrawList's batches, placed in the arena for one frame. Keeps its memory between frames.
class Batches {
 public:
  /// Bytes of a list of `batches` batches beside its vertices and indices, at most, and what the
  /// arena's alignment may cost.
  static std::uint64_t overhead(std::uint64_t batches);
  /// Uploads what the arena does not hold yet. Batches that do not fit are left out and counted;
  /// none is whose vertices, indices and overhead together fit.
  void place(const DrawList& list, const BlockSource& blocks, Morph morph, BlockArena& arena);
  /// One indirect call a topology. Requires: place() of this frame, a bound vertex array.
  void draw(const BlockArena& arena) const;
  /// Binds the factors for the vertex stage. Does nothing when no batch was placed.
  void bind_factors(const BlockArena& arena) const;
  std::size_t count() const { return triangles_.size() + strips_.size(); }
  /// Of the first batch placed, in the arena. Requires: count() > 0.
  std::int32_t first_vertex() const;
  std::uint64_t triangles() const;
  std::uint64_t dropped() const { return dropped_; }

 private:
  enum class Spare { Leave, None };  // room behind a block that grows
  bool place_all(const DrawList& list, Morph morph, Spare spare, BlockArena& arena);
  void send(BlockArena& arena);
  void update_changed(const DrawList& list, const BlockSource& blocks, BlockArena& arena);
  void touch(const DrawList& list, const BlockSource& blocks, BlockArena& arena);
  bool reserve(const DrawList& list, BlockArena& arena);
  std::optional<std::uint64_t> vertices_of(const DrawBatch& batch, Spare spare, BlockArena& arena);
  std::optional<std::uint64_t> indices_of(const DrawBatch& batch, Spare spare, BlockArena& arena);

  const DrawList* list_ = nullptr;
  const BlockSource* blocks_ = nullptr;
  std::vector<DrawCommand> triangles_, strips_;
  std::vector<DrawFactors> factors_;
  std::uint64_t own_vertices_ = 0, own_indices_ = 0;  // offsets in the arena, bytes
  std::uint64_t factors_offset_ = 0, commands_offset_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace arete::render
