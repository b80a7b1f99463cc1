#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/lod/error_tables.h"
#include "arete/lod/rtin.h"
#include "arete/lod/rtin_mesh.h"

namespace arete::lod {

/// One patch of 2^w cells with random heights, and what the method would draw of it.
class RandomPatch {
 public:
  RandomPatch(int w, bool odd, std::uint64_t seed, double roughness) : w_(w), odd_(odd) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise(0, roughness);
    const int n = (1 << w) + 1;
    counts_.resize(static_cast<std::size_t>(n * n));
    const double slope = noise(random);
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        counts_[static_cast<std::size_t>(j * n + i)] = static_cast<std::int32_t>(
            slope * i + 40 * roughness * std::sin(0.2 * i + 0.13 * j * i) + noise(random));
      }
    }
  }

  PatchErrors errors() const { return patch_errors({counts_.data(), posts(), w_, odd_, nullptr}); }
  int posts() const { return (1 << w_) + 1; }
  double height(int i, int j) const { return counts_[static_cast<std::size_t>(j * posts() + i)]; }
  int w() const { return w_; }
  bool odd() const { return odd_; }

  std::vector<Vertex> vertices(int level) const {
    const RtinSquare square{(1 << w_) >> level, odd_};
    std::vector<std::int32_t> sub;
    for (int j = 0; j <= square.cells; ++j) {
      for (int i = 0; i <= square.cells; ++i) {
        sub.push_back(counts_[static_cast<std::size_t>((j << level) * posts() + (i << level))]);
      }
    }
    store::Manifest lattice;
    lattice.quantum_m = 1;
    std::vector<Vertex> out(sub.size());
    make_patch_vertices(square, sub, {0, 0}, level, lattice, out);
    return out;
  }

 private:
  int w_;
  bool odd_;
  std::vector<std::int32_t> counts_;
};

/// Continuous levels of a patch and its sides; every side in [own, own + 1].
struct Levels {
  float own = 0;
  std::array<float, kSides> side{};
};

inline std::array<float, kFactorCount> factors(const Levels& levels, int w, int& level,
                                               unsigned& mask) {
  level = std::min(static_cast<int>(levels.own), w);
  std::array<float, kFactorCount> f{};
  f[0] = levels.own - static_cast<float>(level);
  mask = 0;
  for (const Side q : kAllSides) {
    const float x = levels.side[static_cast<std::size_t>(q)];
    const int e = std::min(static_cast<int>(x), w);
    const float t = x - static_cast<float>(e);
    if (e > level) {
      mask |= 1U << static_cast<unsigned>(q);
      f[PatchSlot::coarser(q)] = t;
      f[PatchSlot::product(q)] = f[0] * t;
    } else {
      f[PatchSlot::own(q)] = t;
    }
  }
  return f;
}

/// Heights of drawn triangles at every post of a patch, row-major: brute force.
inline std::vector<double> heights_of(const std::vector<Vertex>& vertices,
                                      const std::vector<std::uint32_t>& triangles,
                                      const std::array<float, kFactorCount>& f, int posts) {
  std::vector<double> z(static_cast<std::size_t>(posts * posts), std::nan(""));
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    const Vertex& a = vertices[triangles[t]];
    const Vertex& b = vertices[triangles[t + 1]];
    const Vertex& c = vertices[triangles[t + 2]];
    const double za = morphed_z(a, f);
    const double zb = morphed_z(b, f);
    const double zc = morphed_z(c, f);
    const auto cross = [](Post p, Post q, int col, int row) {
      return static_cast<double>((q.col - p.col) * (row - p.row) - (q.row - p.row) * (col - p.col));
    };
    const double area = cross(a.post, b.post, c.post.col, c.post.row);
    for (int row = 0; row < posts; ++row) {
      for (int col = 0; col < posts; ++col) {
        const double u = cross(b.post, c.post, col, row) / area;
        const double v = cross(c.post, a.post, col, row) / area;
        if (u < 0 || v < 0 || u + v > 1) continue;
        z[static_cast<std::size_t>(row * posts + col)] = u * za + v * zb + (1 - u - v) * zc;
      }
    }
  }
  return z;
}

/// Height of the drawn patch at every post.
inline std::vector<double> drawn_heights(const RandomPatch& patch, const Levels& levels) {
  int level = 0;
  unsigned mask = 0;
  const auto f = factors(levels, patch.w(), level, mask);
  const RtinSquare square{(1 << patch.w()) >> level, patch.odd()};
  return heights_of(patch.vertices(level), rtin_triangles(square, level == patch.w() ? 0 : mask), f,
                    patch.posts());
}

}  // namespace arete::lod
