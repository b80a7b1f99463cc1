#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "arete/lod/uniform_mesh.h"

#include "lod/patch_fixture.h"

namespace arete::lod {

/// A random patch drawn with uniform diagonals: its own continuous level, and any coarser one a
/// side.
struct UniformPatch {
  const RandomPatch& patch;
  Levels levels;

  int level() const { return std::min(static_cast<int>(levels.own), patch.w()); }
  float t() const { return levels.own - static_cast<float>(level()); }
  int side_level(Side q) const {
    return std::min(static_cast<int>(levels.side[static_cast<std::size_t>(q)]), patch.w());
  }
  float side_t(Side q) const {
    return levels.side[static_cast<std::size_t>(q)] - static_cast<float>(side_level(q));
  }
  int cells() const { return 1 << (patch.w() - level()); }

  SideDrops drops() const {
    SideDrops out{};
    for (const Side q : kAllSides)
      out[static_cast<std::size_t>(q)] = static_cast<std::uint8_t>(side_level(q) - level());
    return out;
  }

  std::array<float, kFactorCount> factors() const {
    std::array<float, kFactorCount> f{};
    f[UniformSlot::kInterior] = t();
    for (const Side q : kAllSides) {
      f[UniformSlot::side(q)] = side_t(q);
      f[UniformSlot::both(q)] = (1 - side_t(q)) * t();
    }
    return f;
  }

  std::vector<Vertex> vertices() const {
    std::vector<std::int32_t> counts;
    for (int j = 0; j <= cells(); ++j) {
      for (int i = 0; i <= cells(); ++i)
        counts.push_back(static_cast<std::int32_t>(patch.height(i << level(), j << level())));
    }
    store::Manifest lattice;
    lattice.quantum_m = 1;
    std::vector<Vertex> out(counts.size());
    uniform_vertices({counts, cells(), level(), {0, 0}, false}, drops(), lattice, out);
    return out;
  }

  /// Heights at every post of the patch, row-major.
  std::vector<double> drawn() const {
    return heights_of(vertices(), uniform_triangles(cells(), drops()), factors(), patch.posts());
  }
};

inline double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0;
  for (std::size_t k = 0; k < a.size(); ++k) worst = std::max(worst, std::abs(a[k] - b[k]));
  return worst;
}

}  // namespace arete::lod
