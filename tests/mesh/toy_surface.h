#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "arete/core/heightfield.h"
#include "arete/mesh/surface.h"

namespace arete::toy {

using Triangle = std::array<Post, 3>;

inline Heightfield hills(int cols, int rows, std::uint32_t seed = 1) {
  Heightfield dem(cols, rows);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> noise(-0.5F, 0.5F);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      const auto x = static_cast<float>(c);
      const auto y = static_cast<float>(r);
      dem[{c, r}] = 5 * std::sin(0.21F * x) * std::cos(0.17F * y) + noise(random);
    }
  }
  return dem;
}

/// Triangles over the heights of `dem` (0 outside it), one vertex a post.
inline mesh::Surface surface_of(const std::vector<Triangle>& triangles, const Heightfield& dem) {
  mesh::Surface s;
  std::map<std::pair<int, int>, std::uint32_t> index;
  for (const Triangle& t : triangles) {
    for (const Post p : t) {
      const auto [at, added] =
          index.try_emplace({p.col, p.row}, static_cast<std::uint32_t>(s.vertices.size()));
      const bool inside = p.col >= 0 && p.row >= 0 && p.col < dem.cols() && p.row < dem.rows();
      if (added) s.vertices.push_back({p, 0, 0, inside && dem.valid(p) ? dem[p] : 0.0F});
      s.indices.push_back(at->second);
    }
  }
  return s;
}

/// All cells, split along alternating (RTIN) diagonals.
inline std::vector<Triangle> all_cells(int cols, int rows) {
  std::vector<Triangle> out;
  for (int r = 0; r + 1 < rows; ++r) {
    for (int c = 0; c + 1 < cols; ++c) {
      const Post nw{c, r};
      const Post ne{c + 1, r};
      const Post sw{c, r + 1};
      const Post se{c + 1, r + 1};
      if ((c + r) % 2 == 0) {
        out.push_back({nw, sw, se});
        out.push_back({nw, se, ne});
      } else {
        out.push_back({nw, sw, ne});
        out.push_back({ne, sw, se});
      }
    }
  }
  return out;
}

/// A random conforming RTIN triangulation of a square of n = 2^k cells a side.
class RandomRtin {
 public:
  RandomRtin(int n, std::uint32_t seed) {
    const Triangle south{Post{0, n}, Post{n, n}, Post{0, 0}};
    const Triangle north{Post{n, 0}, Post{0, 0}, Post{n, n}};
    link(south, nullptr);
    link(north, nullptr);
    std::mt19937 random(seed);
    std::bernoulli_distribution pick(4.0 / n);
    for (const auto& [vertex, above] : parents_) {
      if (pick(random)) activate(vertex);
    }
    emit(south);
    emit(north);
  }
  const std::vector<Triangle>& triangles() const { return triangles_; }

 private:
  using Key = std::pair<int, int>;

  // Apex first, then the ends of the base, counter-clockwise.
  static Post base(const Triangle& t) {
    return {(t[1].col + t[2].col) / 2, (t[1].row + t[2].row) / 2};
  }
  static bool leaf(const Triangle& t) {
    return (t[1].col + t[2].col) % 2 != 0 || (t[1].row + t[2].row) % 2 != 0;
  }
  static Triangle first(const Triangle& t) { return {base(t), t[0], t[1]}; }
  static Triangle second(const Triangle& t) { return {base(t), t[2], t[0]}; }

  void link(const Triangle& t, const Post* parent) {
    if (leaf(t)) return;
    const Post m = base(t);
    auto& above = parents_[{m.col, m.row}];
    if (parent != nullptr) above.push_back({parent->col, parent->row});
    link(first(t), &m);
    link(second(t), &m);
  }
  void activate(const Key& v) {
    if (std::exchange(active_[v], true)) return;
    for (const Key& p : parents_[v]) activate(p);
  }
  void emit(const Triangle& t) {
    const Post m = base(t);
    if (leaf(t) || !active_[{m.col, m.row}]) {
      triangles_.push_back(t);
      return;
    }
    emit(first(t));
    emit(second(t));
  }

  std::map<Key, std::vector<Key>> parents_;
  std::map<Key, bool> active_;
  std::vector<Triangle> triangles_;
};

}  // namespace arete::toy
