#include "arete/lod/rtin_mesh.h"

#include <bit>

namespace arete::lod {
namespace {

// Height samples of one patch at one level, in lattice counts.
struct Grid {
  const RtinSquare& square;
  std::span<const std::int32_t> counts;
  double quantum_m;

  std::int64_t at(int i, int j) const { return counts[local_vertex(square, i, j)]; }
  // (h(p1) + h(p2)) / 2 - h(v), metres; exact before the last rounding.
  float delta(std::pair<int, int> p1, std::pair<int, int> p2, std::pair<int, int> v) const {
    const std::int64_t twice =
        at(p1.first, p1.second) + at(p2.first, p2.second) - 2 * at(v.first, v.second);
    return static_cast<float>(static_cast<double>(twice) * quantum_m / 2);
  }
};

// The side that a border position lies on (corners excluded by the caller).
Side side_of(const RtinSquare& s, int i, int j) {
  if (i == 0) return West;
  if (j == 0) return North;
  return i == s.cells ? East : South;
}

bool on_border(const RtinSquare& s, int i, int j) {
  return i == 0 || j == 0 || i == s.cells || j == s.cells;
}

// How a side's post of level l+1 moves while the side goes from l+1 to l+2.
float side_delta_coarser(const Grid& g, Side q, int i, int j) {
  if (q == West || q == East) return g.delta({i, j - 2}, {i, j + 2}, {i, j});
  return g.delta({i - 2, j}, {i + 2, j}, {i, j});
}

// Adds the parent's own motion, halved: the last of Wagner's nine factors (METHODS 7.3).
void add_parent(const Grid& g, std::pair<int, int> parent, Vertex& v, std::size_t& k) {
  const auto [i, j] = parent;
  if (!on_border(g.square, i, j)) return;
  const Side q = side_of(g.square, i, j);
  const int along = q == West || q == East ? j : i;
  if (along % 4 != 2) return;  // of level l+2 or coarser: stands still
  v.dz[k] = side_delta_coarser(g, q, i, j) / 2;
  v.slot[k] = PatchSlot::product(q);
  ++k;
}

void set_border_motion(const Grid& g, int i, int j, Vertex& v) {
  const Side q = side_of(g.square, i, j);
  const int along = q == West || q == East ? j : i;
  if (along % 2 != 0) {
    const auto [p1, p2] = morph_parents(g.square, i, j);
    v.dz[0] = g.delta(p1, p2, {i, j});
    v.slot[0] = PatchSlot::own(q);
  } else if (along % 4 == 2) {
    v.dz[0] = side_delta_coarser(g, q, i, j);
    v.slot[0] = PatchSlot::coarser(q);
  }
}

void set_interior_motion(const Grid& g, int i, int j, Vertex& v) {
  if (i % 2 == 0 && j % 2 == 0) return;
  const auto [p1, p2] = morph_parents(g.square, i, j);
  v.dz[0] = g.delta(p1, p2, {i, j});
  v.slot[0] = PatchSlot::kInterior;
  std::size_t k = 1;
  add_parent(g, p1, v, k);
  add_parent(g, p2, v, k);
}

}  // namespace

void make_patch_vertices(const RtinSquare& square, std::span<const std::int32_t> counts,
                         Post origin, int level, const store::Manifest& lattice,
                         std::span<Vertex> out) {
  const Grid g{square, counts, lattice.quantum_m};
  for (int j = 0; j <= square.cells; ++j) {
    for (int i = 0; i <= square.cells; ++i) {
      Vertex v;
      v.post = {origin.col + (i << level), origin.row + (j << level)};
      v.z = static_cast<float>(lattice.offset_m +
                               lattice.quantum_m * static_cast<double>(g.at(i, j)));
      const bool corner = (i == 0 || i == square.cells) && (j == 0 || j == square.cells);
      if (!corner && on_border(square, i, j)) {
        set_border_motion(g, i, j, v);
      } else if (!corner) {
        set_interior_motion(g, i, j, v);
      }
      out[local_vertex(square, i, j)] = v;
    }
  }
}

unsigned RtinMesh::index_variant(const PatchStanding& standing, int cells) const {
  if (cells == 1) return standing.odd ? 1 : 0;
  unsigned mask = 0;
  for (const Side q : kAllSides) {
    if (standing.side[static_cast<std::size_t>(q)].level > standing.own.level)
      mask |= 1U << static_cast<unsigned>(q);
  }
  return mask;
}

std::vector<std::uint32_t> RtinMesh::make_indices(int cells, unsigned variant) const {
  const RtinSquare square{cells, cells == 1 && variant == 1};
  auto list = rtin_triangles(square, cells == 1 ? 0 : variant);
  return topology_ == Topology::Strip ? as_strip(list) : list;
}

std::uint64_t RtinMesh::triangles(int cells, unsigned variant) const {
  const auto n = static_cast<std::uint64_t>(cells);
  if (n == 1) return 2;
  return 2 * n * n - static_cast<std::uint64_t>(std::popcount(variant)) * (n / 2);
}

void RtinMesh::make_vertices(const LevelPosts& posts, unsigned, const store::Manifest& lattice,
                             std::span<Vertex> out) const {
  make_patch_vertices({posts.cells, posts.odd}, posts.counts, posts.origin, posts.level, lattice,
                      out);
}

void RtinMesh::set_factors(const PatchStanding& standing,
                           std::array<float, kFactorCount>& factor) const {
  const Standing& own = standing.own;
  factor[PatchSlot::kInterior] = own.t;
  for (const Side q : kAllSides) {
    const Standing& side = standing.side[static_cast<std::size_t>(q)];
    if (side.level > own.level) {
      factor[PatchSlot::coarser(q)] = side.t;
      factor[PatchSlot::product(q)] = own.t * side.t;
    } else {
      factor[PatchSlot::own(q)] = side.t;
    }
  }
}

}  // namespace arete::lod
