#include "arete/render/batches.h"

#include <algorithm>

namespace arete::render {
namespace {

constexpr std::uint64_t kIndexBytes = sizeof(std::uint32_t);

std::uint64_t factor_alignment() {
  GLint alignment = 0;
  glGetIntegerv(GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT, &alignment);
  return static_cast<std::uint64_t>(std::max(alignment, 1));
}

DrawFactors factors_of(const DrawBatch& batch, Morph morph) {
  DrawFactors f{};
  if (morph == Morph::On) std::copy(batch.factor.begin(), batch.factor.end(), f.factor.begin());
  return f;
}

// Of a block that changes, bytes beside its own.
std::uint64_t room_to_grow(const DrawList& list, const BlockName& name, std::uint64_t bytes) {
  const bool grows = std::any_of(list.uploads.begin(), list.uploads.end(), [&](const Upload& u) {
    return u.block == name.key && u.kind == name.kind;
  });
  return grows ? bytes / 2 : 0;
}

}  // namespace

std::uint64_t Batches::overhead(std::uint64_t batches) {
  const std::uint64_t each = sizeof(DrawFactors) + sizeof(DrawCommand) + BlockArena::kGranule;
  return batches * each + 2 * factor_alignment() + 4 * BlockArena::kGranule;
}

void Batches::place(const DrawList& list, const BlockSource& blocks, Morph morph,
                    BlockArena& arena) {
  list_ = &list;
  blocks_ = &blocks;
  arena.begin_frame();
  update_changed(list, blocks, arena);
  touch(list, blocks, arena);
  if (!place_all(list, morph, Spare::Leave, arena)) {
    // Blocks that other frames left in between may cut the room into pieces: all anew, in a row.
    arena.clear();
    place_all(list, morph, Spare::None, arena);
  }
  if (!factors_.empty()) send(arena);
}

// False when something did not fit.
bool Batches::place_all(const DrawList& list, Morph morph, Spare spare, BlockArena& arena) {
  triangles_.clear();
  strips_.clear();
  factors_.clear();
  dropped_ = list.batches.size();
  if (list.batches.empty()) return true;
  if (!reserve(list, arena)) return false;
  for (const DrawBatch& batch : list.batches) {
    const auto vertices = vertices_of(batch, spare, arena);
    const auto indices = vertices ? indices_of(batch, spare, arena) : std::nullopt;
    if (!indices) continue;
    --dropped_;
    const DrawCommand command{
        batch.index_count, 1,
        static_cast<std::uint32_t>(*indices / kIndexBytes) + batch.first_index,
        static_cast<std::int32_t>(*vertices / sizeof(Vertex)),
        static_cast<std::uint32_t>(factors_.size())};
    (batch.topology == Topology::Strip ? strips_ : triangles_).push_back(command);
    factors_.push_back(factors_of(batch, morph));
  }
  return dropped_ == 0;
}

void Batches::send(BlockArena& arena) {
  arena.write(factors_offset_, std::as_bytes(std::span(factors_)));
  arena.write(commands_offset_, std::as_bytes(std::span(triangles_)));
  arena.write(commands_offset_ + triangles_.size() * sizeof(DrawCommand),
              std::as_bytes(std::span(strips_)));
}

void Batches::update_changed(const DrawList& list, const BlockSource& blocks, BlockArena& arena) {
  for (const Upload& u : list.uploads) {
    const bool vertices = u.kind == BlockKind::Vertices;
    const auto bytes =
        vertices ? std::as_bytes(blocks.vertices(u.block)) : std::as_bytes(blocks.indices(u.block));
    const std::uint64_t each = vertices ? sizeof(Vertex) : kIndexBytes;
    arena.update({&blocks, u.block, u.kind}, bytes, u.first * each, u.count * each);
  }
}

// Before anything is added: what this frame uses must not be evicted for it.
void Batches::touch(const DrawList& list, const BlockSource& blocks, BlockArena& arena) {
  for (const DrawBatch& batch : list.batches) {
    if (batch.vertices != kOwnBlock) arena.find({&blocks, batch.vertices, BlockKind::Vertices});
    if (batch.indices != kOwnBlock) arena.find({&blocks, batch.indices, BlockKind::Indices});
  }
}

bool Batches::reserve(const DrawList& list, BlockArena& arena) {
  const std::size_t n = list.batches.size();
  const auto factors = arena.reserve(n * sizeof(DrawFactors), factor_alignment());
  const auto commands = arena.reserve(n * sizeof(DrawCommand));
  const auto vertices = arena.reserve(list.vertices.size() * sizeof(Vertex));
  const auto indices = arena.reserve(list.indices.size() * kIndexBytes);
  if (!factors || !commands || !vertices || !indices) return false;
  factors_offset_ = *factors;
  commands_offset_ = *commands;
  own_vertices_ = *vertices;
  own_indices_ = *indices;
  arena.write(own_vertices_, std::as_bytes(std::span(list.vertices)));
  arena.write(own_indices_, std::as_bytes(std::span(list.indices)));
  return true;
}

std::optional<std::uint64_t> Batches::vertices_of(const DrawBatch& batch, Spare spare,
                                                  BlockArena& arena) {
  if (batch.vertices == kOwnBlock) return own_vertices_;
  const BlockName name{blocks_, batch.vertices, BlockKind::Vertices};
  if (const auto held = arena.find(name)) return held;
  const auto bytes = std::as_bytes(blocks_->vertices(batch.vertices));
  return arena.add(name, bytes,
                   spare == Spare::Leave ? room_to_grow(*list_, name, bytes.size()) : 0);
}

std::optional<std::uint64_t> Batches::indices_of(const DrawBatch& batch, Spare spare,
                                                 BlockArena& arena) {
  if (batch.indices == kOwnBlock) return own_indices_;
  const BlockName name{blocks_, batch.indices, BlockKind::Indices};
  if (const auto held = arena.find(name)) return held;
  const auto bytes = std::as_bytes(blocks_->indices(batch.indices));
  return arena.add(name, bytes,
                   spare == Spare::Leave ? room_to_grow(*list_, name, bytes.size()) : 0);
}

void Batches::bind_factors(const BlockArena& arena) const {
  if (factors_.empty()) return;
  glBindBufferRange(GL_SHADER_STORAGE_BUFFER, 1, arena.buffer(),
                    static_cast<GLintptr>(factors_offset_),
                    static_cast<GLsizeiptr>(factors_.size() * sizeof(DrawFactors)));
}

void Batches::draw(const BlockArena& arena) const {
  if (count() == 0) return;
  bind_factors(arena);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, arena.buffer());
  const auto call = [](GLenum topology, std::uint64_t offset, std::size_t n) {
    if (n == 0) return;
    // NOLINTNEXTLINE(performance-no-int-to-ptr): GL takes an offset as a pointer.
    const auto* first = reinterpret_cast<const void*>(offset);
    glMultiDrawElementsIndirect(topology, GL_UNSIGNED_INT, first, static_cast<GLsizei>(n), 0);
  };
  call(GL_TRIANGLES, commands_offset_, triangles_.size());
  call(GL_TRIANGLE_STRIP, commands_offset_ + triangles_.size() * sizeof(DrawCommand),
       strips_.size());
}

std::int32_t Batches::first_vertex() const {
  return (triangles_.empty() ? strips_ : triangles_).front().base_vertex;
}

std::uint64_t Batches::triangles() const {
  std::uint64_t n = 0;
  for (const DrawCommand& c : triangles_) n += c.count / 3;
  for (const DrawCommand& c : strips_) n += c.count < 3 ? 0 : c.count - 2;
  return n;
}

}  // namespace arete::render
