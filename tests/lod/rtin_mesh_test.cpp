#include "arete/lod/rtin_mesh.h"

#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "lod/patch_fixture.h"

namespace arete::lod {
namespace {

// The recursive height of METHODS S4: H(v) = (1 - w) h(v) + w (H(p1) + H(p2)) / 2, w = clamp(lambda
// - lev).
class Recursive {
 public:
  Recursive(const RandomPatch& patch, const Levels& levels) : patch_(patch), levels_(levels) {}

  double height(int col, int row) const {
    const int n = patch_.posts() - 1;
    const bool corner = (col == 0 || col == n) && (row == 0 || row == n);
    if (corner) return patch_.height(col, row);
    int lev = 0;
    while (((col >> lev) & 1) == 0 && ((row >> lev) & 1) == 0) ++lev;
    double lambda = levels_.own;
    if (col == 0) lambda = levels_.side[West];
    if (row == 0) lambda = levels_.side[North];
    if (col == n) lambda = levels_.side[East];
    if (row == n) lambda = levels_.side[South];
    const double w = std::clamp(lambda - lev, 0.0, 1.0);
    if (w == 0) return patch_.height(col, row);
    const RtinSquare square{n >> lev, patch_.odd()};
    const auto [p, q] = morph_parents(square, col >> lev, row >> lev);
    const double mean =
        (height(p.first << lev, p.second << lev) + height(q.first << lev, q.second << lev)) / 2;
    return (1 - w) * patch_.height(col, row) + w * mean;
  }

 private:
  const RandomPatch& patch_;
  const Levels& levels_;
};

TEST(RtinMesh, NineFactorsEqualTheRecursiveHeight) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<float> unit(0, 1);
  for (int k = 0; k < 300; ++k) {
    const int w = 2 + k % 4;
    const RandomPatch patch(w, k % 2 == 0, static_cast<std::uint64_t>(k), 25);
    Levels levels;
    levels.own = unit(random) * static_cast<float>(w);
    for (float& side : levels.side)
      side = std::min(static_cast<float>(w), levels.own + unit(random));
    int level = 0;
    unsigned mask = 0;
    const auto f = factors(levels, w, level, mask);
    const Recursive recursive(patch, levels);
    const RtinSquare square{(1 << w) >> level, patch.odd()};
    const auto vertices = patch.vertices(level);
    for (const std::uint32_t v : rtin_triangles(square, level == w ? 0 : mask)) {
      const Vertex& vertex = vertices[v];
      const double expected = recursive.height(vertex.post.col, vertex.post.row);
      EXPECT_NEAR(morphed_z(vertex, f), expected, 1e-6 * std::max(1.0, std::abs(expected)) + 2e-4)
          << "case " << k << " post " << vertex.post.col << ',' << vertex.post.row;
    }
  }
}

// "yMoveSelf, yMoveL2 ... tweeningA = (1 - tL) tI" [Wagner2003] spans the same surface, provided
// that A carries two deltas (METHODS 7.3): tI self + (1 - tL) tI l2 with self = the target with 1
// fully collapsed.
TEST(RtinMesh, PrintedFormOfTheNineEqualsTheProductForm) {
  const RandomPatch patch(4, false, 77, 25);
  const auto vertices = patch.vertices(0);
  int two = 0;
  for (const Vertex& v : vertices) {
    if (v.slot[0] != PatchSlot::kInterior || v.slot[1] != PatchSlot::product(West)) continue;
    ++two;
    const double self = double{v.dz[0]} + double{v.dz[1]};
    const double l2 = -double{v.dz[1]};
    for (const double t_i : {0.0, 0.3, 1.0}) {
      for (const double t_l : {0.0, 0.6, 1.0}) {
        const double product = t_i * v.dz[0] + t_i * t_l * v.dz[1];
        EXPECT_NEAR(t_i * self + (1 - t_l) * t_i * l2, product,
                    1e-6 * (std::abs(self) + std::abs(l2)));
      }
    }
  }
  EXPECT_EQ(two, 4);  // beside posts 2, 6, 10, 14 of the west side
}

TEST(RtinMesh, CornersNeverMove) {
  const RandomPatch patch(4, true, 1, 40);
  for (int level = 0; level <= 4; ++level) {
    const RtinSquare square{16 >> level, true};
    const auto vertices = patch.vertices(level);
    for (const auto& [i, j] :
         {std::pair{0, 0}, {square.cells, 0}, {0, square.cells}, {square.cells, square.cells}}) {
      for (const float d : vertices[local_vertex(square, i, j)].dz) EXPECT_EQ(d, 0);
    }
  }
}

TEST(RtinMesh, FullyMorphedEqualsTheCoarserLevel) {
  const RandomPatch patch(5, false, 4, 30);
  for (int l = 0; l < 5; ++l) {
    const auto x = static_cast<float>(l + 1);
    const auto coarse = drawn_heights(patch, {x, {x, x, x, x}});
    const float below = std::nextafter(x, 0.0F);
    const auto fine = drawn_heights(patch, {below, {below, below, below, below}});
    for (std::size_t k = 0; k < fine.size(); ++k) EXPECT_NEAR(fine[k], coarse[k], 1e-2);
  }
}

}  // namespace
}  // namespace arete::lod
