#include "arete/lod/error_tables.h"

#include <algorithm>
#include <cmath>

namespace arete::lod {
namespace {

// One line of posts with the numerators of a linear height: residual of post k is
// |first + k step - scale * counts[k stride]| / scale.
struct Line {
  const std::int32_t* counts;
  const std::uint8_t* counted;  // or null
  std::ptrdiff_t stride;
  int n;
  double first, step;
};

double worst(const Line& line, double scale) {
  double result = 0;
  if (line.counted == nullptr) {
    for (int k = 0; k < line.n; ++k) {
      const double r = line.first + k * line.step - scale * line.counts[k * line.stride];
      result = std::max(result, std::abs(r));
    }
    return result;
  }
  for (int k = 0; k < line.n; ++k) {
    if (line.counted[k * line.stride] == 0) continue;
    const double r = line.first + k * line.step - scale * line.counts[k * line.stride];
    result = std::max(result, std::abs(r));
  }
  return result;
}

// A frame on the patch: `along` runs on a side, `depth` away from it. All four sides look alike in
// it.
class SideFrame {
 public:
  SideFrame(const PatchHeights& h, Side q) : h_(h) {
    const std::ptrdiff_t n = std::ptrdiff_t{1} << h.log2_cells;
    const bool vertical = q == West || q == East;
    along_ = vertical ? h.stride : 1;
    depth_ = vertical ? 1 : h.stride;
    if (q == East || q == South) {
      origin_ = n * depth_;
      depth_ = -depth_;
    }
  }
  double height(int along, int depth) const { return h_.counts[index(along, depth)]; }

  // Worst residual over the posts of row `depth`, along in [a0, a1], where the height is
  // (z0 + slope (along - a0)) / scale.
  double row(int depth, int a0, int a1, double z0, double slope, double scale) const {
    const std::ptrdiff_t i = index(a0, depth);
    return worst({h_.counts + i, h_.counted == nullptr ? nullptr : h_.counted + i, along_,
                  a1 - a0 + 1, z0, slope},
                 scale);
  }

 private:
  std::ptrdiff_t index(int along, int depth) const {
    return origin_ + along * along_ + depth * depth_;
  }
  const PatchHeights& h_;
  std::ptrdiff_t along_ = 0, depth_ = 0, origin_ = 0;
};

// Numerators are exact integers in double: counts < 2^31, scales <= 2^9.

// The triangle (a0, 0), (a0 + 2s, 0), (a0 + s, s) of an adapted side with end heights za, zc and
// apex zd.
double adapted_triangle(const SideFrame& f, int a0, int s, double za, double zc, double zd) {
  const double scale = 2.0 * s;
  double result = 0;
  for (int depth = 0; depth <= s; ++depth) {
    // z = za + (zc - za) (along - a0) / 2s + (zd - (za + zc)/2) depth / s, times 2s
    const double z0 = scale * za + (2 * zd - za - zc) * depth + (zc - za) * depth;
    result = std::max(result, f.row(depth, a0 + depth, a0 + 2 * s - depth, z0, zc - za, scale));
  }
  return result / scale;
}

// The fan triangle (a, 0), (a, s), (a + dir s, s): corner on the side with height za, the middle of
// the block's end edge ze, the block's centre zd.
double corner_triangle(const SideFrame& f, int a, int dir, int s, std::array<double, 3> z) {
  const auto [za, ze, zd] = z;
  double result = 0;
  for (int depth = 0; depth <= s; ++depth) {
    // z = za + (ze - za) depth / s + (zd - ze) |along - a| / s, times s
    const double at_a = s * za + (ze - za) * depth;
    const double slope = dir * (zd - ze);
    const int a0 = dir > 0 ? a : a - depth;
    const double z0 = dir > 0 ? at_a : at_a - slope * depth;
    result = std::max(result, f.row(depth, a0, a0 + depth, z0, slope, s));
  }
  return result / s;
}

// S1[l]: side collapsed to l+1.
double strip_one(const SideFrame& f, int cells, int s) {
  double result = 0;
  for (int a = 0; a < cells; a += 2 * s) {
    result = std::max(result, adapted_triangle(f, a, s, f.height(a, 0), f.height(a + 2 * s, 0),
                                               f.height(a + s, s)));
  }
  return result;
}

// Height on the side at level l+2: odd posts of level l+1 lie between their neighbours.
double collapsed(const SideFrame& f, int along, int s) {
  if ((along / (2 * s)) % 2 == 0) return f.height(along, 0);
  return (f.height(along - 2 * s, 0) + f.height(along + 2 * s, 0)) / 2;
}

// S2[l]: side collapsed to l+2. The triangles that share a moved corner move too.
double strip_two(const SideFrame& f, int cells, int s) {
  double result = 0;
  for (int a = 0; a < cells; a += 2 * s) {
    const int c = a + 2 * s;
    const double za = collapsed(f, a, s);
    const double zc = collapsed(f, c, s);
    const double zd = f.height(a + s, s);
    result = std::max({result, adapted_triangle(f, a, s, za, zc, zd),
                       corner_triangle(f, a, 1, s, {za, f.height(a, s), zd}),
                       corner_triangle(f, c, -1, s, {zc, f.height(c, s), zd})});
  }
  return result;
}

}  // namespace

double cell_residual(const PatchHeights& h, Post first, int s, Diagonal diagonal) {
  const std::ptrdiff_t origin = first.row * h.stride + first.col;
  const auto at = [&](int c, int r) -> double { return h.counts[origin + r * h.stride + c]; };
  const double nw = at(0, 0);
  const double ne = at(s, 0);
  const double sw = at(0, s);
  const double se = at(s, s);
  double result = 0;
  for (int r = 0; r <= s; ++r) {
    const std::ptrdiff_t i = origin + r * h.stride;
    const auto part = [&](int c0, int c1, double at0, double step) {
      const std::uint8_t* counted = h.counted == nullptr ? nullptr : h.counted + i + c0;
      result = std::max(result, worst({h.counts + i + c0, counted, 1, c1 - c0 + 1, at0, step}, s));
    };
    if (diagonal == Diagonal::Falls) {  // NW-SE: below it NW, SW, SE; above it NW, NE, SE
      part(0, r, s * nw + (sw - nw) * r, se - sw);
      part(r, s, s * nw + (ne - nw) * r + (se - ne) * r, ne - nw);
    } else {  // NE-SW: above it NW, NE, SW; below it NE, SW, SE
      part(0, s - r, s * nw + (sw - nw) * r, ne - nw);
      part(s - r, s, s * se + (ne - se) * (s - r) + (sw - se) * r, se - sw);
    }
  }
  return result / s;
}

PatchErrors patch_errors(const PatchHeights& h) {
  const int w = h.log2_cells;
  const int cells = 1 << w;
  const auto knots = static_cast<std::size_t>(w + 1);
  PatchErrors e;
  e.uniform.assign(knots, 0);
  for (auto& side : e.side) side.assign(knots, 0);
  for (int l = 1; l <= w; ++l) {
    const auto level = static_cast<std::size_t>(l);
    const int s = 1 << l;
    const RtinSquare square{cells / s, h.odd};
    for (int j = 0; j < square.cells; ++j) {
      for (int i = 0; i < square.cells; ++i) {
        const Diagonal diagonal = diagonal_falls(square, i, j) ? Diagonal::Falls : Diagonal::Rises;
        const double r = cell_residual(h, {i * s, j * s}, s, diagonal);
        e.uniform[level] = std::max(e.uniform[level], r);
        const std::array<bool, kSides> in_band{i < 2, j < 2, i >= square.cells - 2,
                                               j >= square.cells - 2};
        for (std::size_t q = 0; q < kSides; ++q) {
          if (in_band[q]) e.side[q][level] = std::max(e.side[q][level], r);  // E[m]
        }
      }
    }
  }
  for (const Side q : kAllSides) {
    auto& side = e.side[static_cast<std::size_t>(q)];
    const SideFrame frame(h, q);
    for (std::size_t l = 0; l + 1 < knots; ++l) {
      side[l + 1] = std::max(side[l + 1], strip_one(frame, cells, 1 << l));
      if (l + 2 < knots) side[l + 2] = std::max(side[l + 2], strip_two(frame, cells, 1 << l));
    }
  }
  return e;
}

}  // namespace arete::lod
