#include "arete/lod/uniform_mesh.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstddef>

namespace arete::lod {
namespace {

// A position in the patch: i east, j south.
struct At {
  int i, j;
};

// `along` runs on side q eastward or southward, `depth` away from it.
At on_side(Side q, int cells, int along, int depth) {
  switch (q) {
    case West:
      return {depth, along};
    case North:
      return {along, depth};
    case East:
      return {cells - depth, along};
    default:
      return {along, cells - depth};
  }
}

class TriangleWriter {
 public:
  TriangleWriter(int cells, const SideDrops& drops) : n_(cells), drops_(drops) {
    out_.reserve(3 * uniform_triangle_count(cells, drops));
  }

  std::vector<std::uint32_t> run() {
    // Columns northwards: the order in which cells with this diagonal form a strip.
    for (int i = 0; i < n_; ++i) {
      for (int j = n_ - 1; j >= 0; --j) add_cell(i, j);
    }
    for (const Side q : kAllSides) {
      if (adapted(q)) add_band(q);
    }
    return std::move(out_);
  }

 private:
  bool adapted(Side q) const { return drops_[static_cast<std::size_t>(q)] != 0; }

  void add_cell(int i, int j) {
    const At nw{i, j};
    const At ne{i + 1, j};
    const At sw{i, j + 1};
    const At se{i + 1, j + 1};
    const bool beside_row = i == 0 || i == n_ - 1;
    const bool beside_column = j == 0 || j == n_ - 1;
    const bool row_adapted = beside_row && adapted(i == 0 ? West : East);
    const bool column_adapted = beside_column && adapted(j == 0 ? North : South);
    if (!row_adapted && !column_adapted) {
      add(sw, se, nw);
      add(nw, se, ne);
    } else if (beside_row && beside_column && row_adapted != column_adapted) {
      add_half_corner(i, j, row_adapted);
    }
  }

  // A corner cell of which one side's band takes a half: the other half remains, cut from the
  // patch's corner whatever the diagonals elsewhere.
  void add_half_corner(int i, int j, bool row_adapted) {
    const At corner{i == 0 ? 0 : n_, j == 0 ? 0 : n_};
    const At inner{i == 0 ? 1 : n_ - 1, j == 0 ? 1 : n_ - 1};
    add(corner, inner, row_adapted ? At{inner.i, corner.j} : At{corner.i, inner.j});
  }

  // From corner to corner: each kept post fans over the inner posts nearest to it.
  void add_band(Side q) {
    const int step = 1 << drops_[static_cast<std::size_t>(q)];
    const auto outer = [&](int along) { return on_side(q, n_, along, 0); };
    const auto inner = [&](int along) { return on_side(q, n_, along, 1); };
    int next = 1;
    for (int a = 0; a <= n_; a += step) {
      const int last = std::min(a + step / 2, n_ - 1);
      for (; next < last; ++next) add(outer(a), inner(next), inner(next + 1));
      if (a < n_) add(outer(a), inner(last), outer(a + step));
    }
  }

  void add(At a, At b, At c) {
    // Rows run south: counter-clockwise seen from above is clockwise in (i, j).
    const int cross = (b.i - a.i) * (c.j - a.j) - (b.j - a.j) * (c.i - a.i);
    assert(cross != 0);
    if (cross > 0) std::swap(b, c);
    for (const At p : {a, b, c}) out_.push_back(local_vertex({n_}, p.i, p.j));
  }

  int n_;
  const SideDrops& drops_;
  std::vector<std::uint32_t> out_;
};

}  // namespace

std::vector<std::uint32_t> uniform_triangles(int cells, const SideDrops& drops) {
  assert(std::ranges::all_of(drops, [&](int drop) { return (1 << drop) <= cells; }));
  return TriangleWriter(cells, drops).run();
}

std::uint64_t uniform_triangle_count(int cells, const SideDrops& drops) {
  const auto n = static_cast<std::uint64_t>(cells);
  std::uint64_t count = 2 * n * n;
  for (const unsigned drop : drops) count -= n - (n >> drop);
  return count;
}

namespace {

using Corners = std::span<const std::uint32_t, 3>;

// The place of the directed edge in the triangle; 3 when it is not there.
std::size_t edge_place(Corners corner, std::uint32_t from, std::uint32_t to) {
  std::size_t k = 0;
  while (k < 3 && (corner[k] != from || corner[(k + 1) % 3] != to)) ++k;
  return k;
}

// Takes triangles in their order, each in constant time.
class StripWriter {
 public:
  explicit StripWriter(std::span<const std::uint32_t> triangles) : triangles_(triangles) {
    strip_.reserve(triangles.size());
  }

  std::vector<std::uint32_t> run() {
    for (std::size_t t = 0; t < count(); ++t) {
      if (!go_on(t)) start(t);
    }
    return std::move(strip_);
  }

 private:
  std::size_t count() const { return triangles_.size() / 3; }
  Corners corners(std::size_t t) const { return triangles_.subspan(3 * t).first<3>(); }

  // Across the strip's last edge. When the triangle after this one lies across the edge that the
  // strip would leave behind, a repeated vertex turns the strip: fans.
  bool go_on(std::size_t t) {
    const std::size_t n = strip_.size();
    if (n < 3) return false;
    // The next triangle of a strip is (n-2, n-1, new), turned over at odd places.
    const std::uint32_t x = strip_[n - 2];
    const std::uint32_t y = strip_[n - 1];
    const std::size_t k = n % 2 == 0 ? edge_place(corners(t), x, y) : edge_place(corners(t), y, x);
    if (k == 3) return false;
    const std::uint32_t z = corners(t)[(k + 2) % 3];
    if (t + 1 < count() &&
        (edge_place(corners(t + 1), x, z) < 3 || edge_place(corners(t + 1), z, x) < 3))
      strip_.push_back(x);
    strip_.push_back(z);
    return true;
  }

  void start(std::size_t t) {
    const Corners corner = corners(t);
    std::size_t first = 0;  // such that the next triangle lies across the last edge
    for (std::size_t k = 0; t + 1 < count() && k < 3; ++k) {
      if (edge_place(corners(t + 1), corner[(k + 2) % 3], corner[(k + 1) % 3]) < 3) first = k;
    }
    if (!strip_.empty()) {
      strip_.insert(strip_.end(), {strip_.back(), corner[first]});
      if (strip_.size() % 2 != 0) strip_.push_back(corner[first]);  // the parity of the winding
    }
    for (std::size_t k = 0; k < 3; ++k) strip_.push_back(corner[(first + k) % 3]);
  }

  std::span<const std::uint32_t> triangles_;
  std::vector<std::uint32_t> strip_;
};

}  // namespace

std::vector<std::uint32_t> uniform_strip(int cells, const SideDrops& drops) {
  const auto list = uniform_triangles(cells, drops);
  // Around the one inner post of two cells nothing runs in columns.
  return cells <= 2 ? as_strip(list) : StripWriter(list).run();
}

namespace {

// A height that moves with a side's factor, in counts: base + t delta.
struct Moving {
  double base = 0, delta = 0;
};

class VertexWriter {
 public:
  VertexWriter(const LevelPosts& posts, const SideDrops& drops, const store::Manifest& lattice)
      : posts_(posts), n_(posts.cells), drops_(drops), lattice_(lattice) {}

  Vertex make(int i, int j) const {
    Vertex v;
    v.post = {posts_.origin.col + (i << posts_.level), posts_.origin.row + (j << posts_.level)};
    v.z = static_cast<float>(lattice_.offset_m + lattice_.quantum_m * at({i, j}));
    const bool on_row = i == 0 || i == n_;
    const bool on_column = j == 0 || j == n_;
    if (on_row && on_column) return v;  // corners stand still
    if (on_row) move_side(i == 0 ? West : East, j, v);
    if (on_column) move_side(j == 0 ? North : South, i, v);
    if (!on_row && !on_column && (i % 2 != 0 || j % 2 != 0)) move_inside(i, j, v);
    return v;
  }

 private:
  double at(At p) const { return posts_.counts[local_vertex({n_}, p.i, p.j)]; }
  float metres(double counts) const { return static_cast<float>(counts * lattice_.quantum_m); }

  void move_side(Side q, int along, Vertex& v) const {
    const double delta = kept(q, along).delta;
    if (delta == 0) return;
    v.dz[0] = metres(delta);
    v.slot[0] = UniformSlot::side(q);
  }

  // A post that the side keeps: it leaves with the side's next level when that is its own.
  Moving kept(Side q, int along) const {
    const int drop = drops_[static_cast<std::size_t>(q)];
    const double h = at(on_side(q, n_, along, 0));
    if (along == 0 || along == n_ || std::countr_zero(static_cast<unsigned>(along)) != drop)
      return {h, 0};
    const int step = 1 << drop;
    const double ends = at(on_side(q, n_, along - step, 0)) + at(on_side(q, n_, along + step, 0));
    return {h, ends / 2 - h};
  }

  // Where the side stands beside any of its posts.
  Moving side_height(Side q, int along) const {
    const int step = 1 << drops_[static_cast<std::size_t>(q)];
    const int rest = along % step;
    if (rest == 0) return kept(q, along);
    const Moving a = kept(q, along - rest);
    const Moving b = kept(q, along - rest + step);
    const double share = static_cast<double>(rest) / step;
    return {a.base + share * (b.base - a.base), a.delta + share * (b.delta - a.delta)};
  }

  // "This vertex has to move into the middle position between" left and right, top-left and
  // bottom-right, or top and bottom [Wagner2003, cases A, B, C].
  void move_inside(int i, int j, Vertex& v) const {
    const int di = i % 2;
    const int dj = j % 2;
    double target = 0;
    std::size_t k = 1;
    for (const At p : {At{i - di, j - dj}, At{i + di, j + dj}}) {
      const Moving parent = parent_height(p, k, v);
      target += (parent.base + parent.delta) / 2;
    }
    v.dz[0] = metres(target - at({i, j}));
    v.slot[0] = UniformSlot::kInterior;
  }

  Moving parent_height(At p, std::size_t& k, Vertex& v) const {
    const bool on_row = p.i == 0 || p.i == n_;
    const bool on_column = p.j == 0 || p.j == n_;
    if (on_row == on_column) return {at(p), 0};  // inside, or a corner
    const Side row_side = p.i == 0 ? West : East;
    const Side column_side = p.j == 0 ? North : South;
    const Side q = on_row ? row_side : column_side;
    const Moving parent = side_height(q, on_row ? p.j : p.i);
    if (parent.delta != 0) {
      // tI (target at tL = 1) + (1 - tL) tI (-delta / 2)
      v.dz[k] = metres(-parent.delta / 2);
      v.slot[k] = UniformSlot::both(q);
      ++k;
    }
    return parent;
  }

  const LevelPosts& posts_;
  int n_;
  const SideDrops& drops_;
  const store::Manifest& lattice_;
};

}  // namespace

void uniform_vertices(const LevelPosts& posts, const SideDrops& drops,
                      const store::Manifest& lattice, std::span<Vertex> out) {
  const VertexWriter writer(posts, drops, lattice);
  for (int j = 0; j <= posts.cells; ++j) {
    for (int i = 0; i <= posts.cells; ++i)
      out[local_vertex({posts.cells}, i, j)] = writer.make(i, j);
  }
}

namespace {

// Index variants count the drops of the four sides, each 0 to log2 cells.
unsigned drop_count(int cells) {
  return static_cast<unsigned>(std::countr_zero(static_cast<unsigned>(cells))) + 1;
}

SideDrops drops_of(const PatchStanding& standing) {
  SideDrops drops{};
  for (std::size_t q = 0; q < drops.size(); ++q)
    drops[q] = static_cast<std::uint8_t>(standing.side[q].level - standing.own.level);
  return drops;
}

SideDrops index_drops(int cells, unsigned variant) {
  SideDrops drops{};
  for (std::uint8_t& drop : drops) {
    drop = static_cast<std::uint8_t>(variant % drop_count(cells));
    variant /= drop_count(cells);
  }
  return drops;
}

constexpr unsigned kDropBits = 3;  // of a vertex variant, a side
static_assert(UniformMesh::kMostLog2Cells < 1 << kDropBits);

}  // namespace

unsigned UniformMesh::index_variants(int cells) const {
  const unsigned n = drop_count(cells);
  return n * n * n * n;
}

unsigned UniformMesh::index_variant(const PatchStanding& standing, int cells) const {
  const SideDrops drops = drops_of(standing);
  unsigned variant = 0;
  for (std::size_t q = drops.size(); q-- > 0;) variant = variant * drop_count(cells) + drops[q];
  return variant;
}

std::vector<std::uint32_t> UniformMesh::make_indices(int cells, unsigned variant) const {
  const SideDrops drops = index_drops(cells, variant);
  return topology_ == Topology::Strip ? uniform_strip(cells, drops)
                                      : uniform_triangles(cells, drops);
}

std::uint64_t UniformMesh::triangles(int cells, unsigned variant) const {
  return uniform_triangle_count(cells, index_drops(cells, variant));
}

unsigned UniformMesh::vertex_variant(const PatchStanding& standing) const {
  if (towards_ == Towards::Stored) return 0;
  const SideDrops drops = drops_of(standing);
  unsigned variant = 0;
  for (std::size_t q = drops.size(); q-- > 0;) variant = variant << kDropBits | drops[q];
  return variant;
}

void UniformMesh::make_vertices(const LevelPosts& posts, unsigned variant,
                                const store::Manifest& lattice, std::span<Vertex> out) const {
  SideDrops drops{};
  for (std::uint8_t& drop : drops) {
    drop = static_cast<std::uint8_t>(variant & ((1U << kDropBits) - 1));
    variant >>= kDropBits;
  }
  uniform_vertices(posts, drops, lattice, out);
}

void UniformMesh::set_factors(const PatchStanding& standing,
                              std::array<float, kFactorCount>& factor) const {
  factor[UniformSlot::kInterior] = standing.own.t;
  for (const Side q : kAllSides) {
    const float t = standing.side[static_cast<std::size_t>(q)].t;
    factor[UniformSlot::side(q)] = t;
    factor[UniformSlot::both(q)] = (1 - t) * standing.own.t;
  }
}

}  // namespace arete::lod
