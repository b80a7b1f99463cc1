#include "arete/mesh/surface.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <span>

namespace arete::mesh {
namespace {

// Where each vertex of a block went in the surface; entries of older batches are told by their
// stamp, so nothing is cleared between batches.
struct Placed {
  std::uint32_t stamp = 0, index = 0;
};

float factor_of(const DrawBatch& batch, std::uint8_t slot) {
  return slot < kFactorCount ? batch.factor[slot] : 0.0F;
}

class Flattener {
 public:
  explicit Flattener(Surface& out) : out_(out) {}

  void add(const DrawBatch& batch, std::span<const Vertex> vertices,
           std::span<const std::uint32_t> indices) {
    batch_ = &batch;
    vertices_ = vertices;
    ++stamp_;
    if (placed_.size() < vertices.size()) placed_.resize(vertices.size());
    if (batch.topology == Topology::Triangles) {
      for (std::size_t i = 0; i + 3 <= indices.size(); i += 3) {
        add_triangle(indices[i], indices[i + 1], indices[i + 2]);
      }
      return;
    }
    for (std::size_t i = 0; i + 3 <= indices.size(); ++i) {
      const std::size_t odd = i & 1U;  // every other triangle of a strip is wound backwards
      add_triangle(indices[i + odd], indices[i + 1 - odd], indices[i + 2]);
    }
  }

 private:
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a == b || b == c || c == a) return;
    const std::array<std::uint32_t, 3> corners{place_once(a), place_once(b), place_once(c)};
    out_.indices.insert(out_.indices.end(), corners.begin(), corners.end());
  }

  std::uint32_t place_once(std::uint32_t v) {
    assert(v < vertices_.size());
    Placed& p = placed_[v];
    if (p.stamp != stamp_) {
      p = {stamp_, static_cast<std::uint32_t>(out_.vertices.size())};
      out_.vertices.push_back(drawn_vertex(vertices_[v], *batch_));
    }
    return p.index;
  }

  Surface& out_;
  std::vector<Placed> placed_;
  std::uint32_t stamp_ = 0;
  const DrawBatch* batch_ = nullptr;
  std::span<const Vertex> vertices_;
};

}  // namespace

void Surface::clear() {
  vertices.clear();
  indices.clear();
}

SurfaceVertex drawn_vertex(const Vertex& v, const DrawBatch& batch) {
  const float f = v.dcol == 0 && v.drow == 0 ? 0.0F : factor_of(batch, v.slot[0]);
  return {v.post, static_cast<float>(v.dcol) * f, static_cast<float>(v.drow) * f,
          morphed_z(v, batch.factor)};
}

std::span<const Vertex> vertices_of(const DrawBatch& batch, const DrawList& list,
                                    const BlockSource& blocks) {
  return batch.vertices == kOwnBlock ? list.vertices : blocks.vertices(batch.vertices);
}

std::span<const std::uint32_t> indices_of(const DrawBatch& batch, const DrawList& list,
                                          const BlockSource& blocks) {
  const std::span<const std::uint32_t> all =
      batch.indices == kOwnBlock ? list.indices : blocks.indices(batch.indices);
  return all.subspan(batch.first_index, batch.index_count);
}

void flatten(const DrawList& list, const BlockSource& blocks, Surface& out) {
  out.clear();
  Flattener flattener(out);
  for (const DrawBatch& b : list.batches) {
    flattener.add(b, vertices_of(b, list, blocks), indices_of(b, list, blocks));
  }
}

}  // namespace arete::mesh
