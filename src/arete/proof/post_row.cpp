#include "arete/proof/post_row.h"

#include <algorithm>
#include <limits>

namespace arete::proof {

void ScreenShift::squared_px(Post first, const double* from, const double* to,
                             RowValues& out) const {
  const glm::dvec3 start = projection_.clip(first.col, first.row, 0);
  const glm::dvec3 col = projection_.per_col;
  const glm::dvec3 up = projection_.per_metre;
  const double near = projection_.near_m;
  const double sx = scale_x_;
  const double sy = scale_y_;
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (int i = 0; i < Reference::kTilePosts; ++i) {
    const double z = from[i];
    const double dz = to[i] - z;
    const double x = start.x + i * col.x + z * up.x;
    const double y = start.y + i * col.y + z * up.y;
    const double w = start.z + i * col.z + z * up.z;
    const double moved_w = w + dz * up.z;
    // (x + dz ux) / (w + dz uw) - x / w over one denominator: nothing cancels.
    const double f = dz / (moved_w * w);
    const double px = sx * f * (up.x * w - x * up.z);
    const double py = sy * f * (up.y * w - y * up.z);
    const double before_near = ((moved_w < near) | (w < near)) ? kInfinite : 0.0;
    out[static_cast<std::size_t>(i)] = px * px + py * py + before_near;
  }
}

void ScreenShift::drop_unseen(Post first, const RowValues& z, RowValues& values) const {
  const glm::dvec3 start = projection_.clip(first.col, first.row, 0);
  const glm::dvec3 col = projection_.per_col;
  const glm::dvec3 up = projection_.per_metre;
  const double near = projection_.near_m;
  for (int i = 0; i < Reference::kTilePosts; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double x = start.x + i * col.x + z[k] * up.x;
    const double y = start.y + i * col.y + z[k] * up.y;
    const double w = start.z + i * col.z + z[k] * up.z;
    // One comparison, so that no branch is left; false for NaN.
    const double margin = std::min({w - near, w - std::abs(x), w - std::abs(y)});
    values[k] = margin >= 0 ? values[k] : -1.0;
  }
}

}  // namespace arete::proof
