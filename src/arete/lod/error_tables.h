#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "arete/core/post.h"
#include "arete/lod/rtin.h"

namespace arete::lod {

/// Heights of one patch: (2^log2_cells + 1)^2 lattice counts, row-major, NW first, `stride` apart a
/// row.
struct PatchHeights {
  const std::int32_t* counts = nullptr;
  std::ptrdiff_t stride = 0;
  int log2_cells = 0;
  bool odd = false;  ///< parity of the patch: RtinSquare::odd
  /// 1 = the post belongs to a drawable cell, same layout as counts; null = all do.
  const std::uint8_t* counted = nullptr;
};

/// Exact maxima of |surface - height| in lattice counts over the counted posts of a patch, a side
/// of 2^w cells; each array has w + 1 entries, entry 0 is 0 (METHODS S3, changed as said here).
///
/// `uniform[l]`: every side at level l, the patch at level l.
/// `side[q][m]`: the band along side q while that side stands at level m, whatever level the
/// interior has among m, m-1, m-2 that may meet it:
///   side[q][m] = max(E[m], S1[m-1], S2[m-2]),
/// E[l] the uniform mesh, S1[l] / S2[l] the mesh of level l whose side is collapsed to level l+1 /
/// l+2. The band is the row of 2x2-cell blocks (of the interior's level) along the side: the
/// triangles that depend on the side's factors all lie in it.
///
/// Why these knots bound everything in between. For an interior level l+t and a side level x the
/// height of a post of the band is affine in t and, in x, piecewise affine with knots l+1 and l+2;
/// so its error is at most the same mix of the errors at the knots. With u = x - m, m = floor(x),
/// the mixes are
///   l = m:      between (1-u) E[m] + u S1[m] (t = 0) and (1-u) E[m] + u E[m+1] (t = u),
///   l = m - 1:  (1-u)[(1-t) S1[m-1] + t E[m]] + u [(1-t) S2[m-1] + t S1[m]],
/// all of them <= (1-u) side[m] + u side[m+1]: linear interpolation of `side` bounds the band for
/// every interior level in [x-1, x] at once. That makes the coupling of neighbours monotone
/// (LevelField).
struct PatchErrors {
  std::vector<double> uniform;
  std::array<std::vector<double>, kSides> side;
};

PatchErrors patch_errors(const PatchHeights& heights);

enum class Diagonal { Falls, Rises };  ///< NW to SE, NE to SW

/// Maximum of |surface - height| in counts over the counted posts of the closed square of `size`
/// cells a side whose NW post is `first`, drawn as two triangles.
double cell_residual(const PatchHeights& heights, Post first, int size, Diagonal diagonal);

}  // namespace arete::lod
