#include "arete/lod/rtin.h"

#include <algorithm>
#include <cassert>
#include <map>
#include <span>

namespace arete::lod {
namespace {

// The ring of a 2x2 block counter-clockwise seen from above: SE, E, NE, N, NW, W, SW, S.
constexpr std::array<std::pair<int, int>, 8> kRing{
    {{2, 2}, {2, 1}, {2, 0}, {1, 0}, {0, 0}, {0, 1}, {0, 2}, {1, 2}}};

// The side whose odd vertex ring position k would be; -1 for corners.
int ring_side(std::size_t k) {
  constexpr std::array<int, 8> kRingSides{-1, East, -1, North, -1, West, -1, South};
  return kRingSides[k];
}

// True when the 2x2 block at (i, j) touches side q of the square.
bool touches(const RtinSquare& square, int i, int j, int q) {
  switch (q) {
    case West:
      return i == 0;
    case North:
      return j == 0;
    case East:
      return i + 2 == square.cells;
    default:
      return j + 2 == square.cells;
  }
}

// A fan of up to 8 triangles around the (odd, odd) centre; adapted sides lose their odd vertex.
void append_fan(const RtinSquare& square, int i, int j, unsigned side_mask,
                std::vector<std::uint32_t>& out) {
  std::array<std::uint32_t, 8> ring{};
  std::size_t n = 0;
  for (std::size_t k = 0; k < kRing.size(); ++k) {
    const int q = ring_side(k);
    const bool dropped =
        q >= 0 && (side_mask >> static_cast<unsigned>(q) & 1U) != 0 && touches(square, i, j, q);
    if (!dropped) ring[n++] = local_vertex(square, i + kRing[k].first, j + kRing[k].second);
  }
  const std::uint32_t centre = local_vertex(square, i + 1, j + 1);
  for (std::size_t k = 0; k < n; ++k) out.insert(out.end(), {centre, ring[k], ring[(k + 1) % n]});
}

}  // namespace

bool diagonal_falls(const RtinSquare& square, int i, int j) {
  return ((i + j + (square.cells == 1 && square.odd ? 1 : 0)) & 1) == 0;
}

std::pair<std::pair<int, int>, std::pair<int, int>> morph_parents(const RtinSquare& square, int i,
                                                                  int j) {
  assert((i & 1) != 0 || (j & 1) != 0);
  if ((j & 1) == 0) return {{i - 1, j}, {i + 1, j}};
  if ((i & 1) == 0) return {{i, j - 1}, {i, j + 1}};
  const RtinSquare coarse{square.cells / 2, square.odd};
  if (diagonal_falls(coarse, (i - 1) / 2, (j - 1) / 2)) return {{i - 1, j - 1}, {i + 1, j + 1}};
  return {{i + 1, j - 1}, {i - 1, j + 1}};
}

std::vector<std::uint32_t> rtin_triangles(const RtinSquare& square, unsigned side_mask) {
  std::vector<std::uint32_t> out;
  if (square.cells == 1) {
    assert(side_mask == 0);
    // Corners NW 0, NE 1, SW 2, SE 3.
    if (diagonal_falls(square, 0, 0)) return {0, 2, 3, 0, 3, 1};
    return {0, 2, 1, 1, 2, 3};
  }
  out.reserve(static_cast<std::size_t>(square.cells) * static_cast<std::size_t>(square.cells) * 6);
  for (int j = 0; j < square.cells; j += 2) {
    for (int i = 0; i < square.cells; i += 2) append_fan(square, i, j, side_mask, out);
  }
  return out;
}

namespace {

// Grows strips greedily over the triangle list: from the last edge of the strip on to the unused
// triangle across it.
class Stripifier {
 public:
  explicit Stripifier(std::span<const std::uint32_t> triangles) : triangles_(triangles) {
    used_.resize(triangles.size() / 3);
    for (std::size_t t = 0; t < used_.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) across_[{corner(t, k), corner(t, k + 1)}] = t;
    }
  }

  std::vector<std::uint32_t> run() {
    for (std::size_t t = 0; t < used_.size(); ++t) {
      if (!used_[t]) start(t);
    }
    return strip_;
  }

 private:
  std::uint32_t corner(std::size_t t, std::size_t k) const { return triangles_[3 * t + k % 3]; }

  // Joins with two repeated vertices, and a third when the parity of the winding asks for it.
  void start(std::size_t t) {
    used_[t] = true;
    const std::size_t first = best_rotation(t);
    if (!strip_.empty()) {
      strip_.push_back(strip_.back());
      strip_.push_back(corner(t, first));
      if (strip_.size() % 2 != 0) strip_.push_back(corner(t, first));
    }
    for (std::size_t k = 0; k < 3; ++k) strip_.push_back(corner(t, first + k));
    while (extend()) {
    }
  }

  // The rotation whose last edge has an unused triangle across it, if any.
  std::size_t best_rotation(std::size_t t) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto it = across_.find({corner(t, k + 2), corner(t, k + 1)});
      if (it != across_.end() && !used_[it->second]) return k;
    }
    return 0;
  }

  bool extend() {
    const std::size_t n = strip_.size();
    std::pair<std::uint32_t, std::uint32_t> edge{strip_[n - 2], strip_[n - 1]};
    // The next triangle of a strip is (n-2, n-1, new), turned over at odd places.
    if (n % 2 != 0) std::swap(edge.first, edge.second);
    const auto it = across_.find(edge);
    if (it == across_.end() || used_[it->second]) return false;
    const std::size_t t = it->second;
    used_[t] = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = corner(t, k);
      if (v != edge.first && v != edge.second) strip_.push_back(v);
    }
    return true;
  }

  std::span<const std::uint32_t> triangles_;
  std::vector<bool> used_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t>
      across_;  // directed edge -> triangle
  std::vector<std::uint32_t> strip_;
};

}  // namespace

std::vector<std::uint32_t> as_strip(std::span<const std::uint32_t> triangles) {
  return Stripifier(triangles).run();
}

}  // namespace arete::lod
