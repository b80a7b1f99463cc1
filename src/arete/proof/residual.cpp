#include "arete/proof/residual.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "arete/core/screen_error.h"
#include "arete/proof/drawn_posts.h"
#include "arete/proof/post_row.h"
#include "arete/proof/sum_over_tiles.h"

namespace arete::proof {
namespace {

class ResidualMeter {
 public:
  ResidualMeter(const mesh::Surface& surface, const Reference& reference, const View& view,
                std::span<const int> tiles)
      : reference_(reference),
        drawn_(surface, reference, tiles),
        screen_(view, reference.world_from_post()),
        eye_(view.eye),
        alpha_(pixel_scale(view, ErrorScale::Angular)) {}

  void measure(int tile, Residuals& sum) const {
    PostHeights heights;
    drawn_.read(tile, heights);
    for_each_row(reference_, tile,
                 [&](const PostRow& row) { add(row, &heights[row.offset], sum); });
  }

 private:
  void add(const PostRow& row, const double* drawn_z, Residuals& sum) const {
    RowValues squared_px;
    RowValues squared_angle;
    screen_.squared_px(row.first, row.true_z.data(), drawn_z, squared_px);
    screen_.drop_unseen(row.first, row.true_z, squared_px);
    squared_angles(row, drawn_z, squared_angle);
    double worst = 0;
    for (std::size_t i = 0; i < squared_px.size(); ++i) {
      if (squared_px[i] < 0) continue;
      if (std::isnan(squared_px[i])) {
        ++sum.undrawn;
        continue;
      }
      sum.px.add_squared(squared_px[i]);
      worst = std::max(worst, squared_angle[i]);
    }
    sum.max_angular_px = std::max(sum.max_angular_px, alpha_ * std::sqrt(worst));
  }

  // (delta / D)^2 of each post.
  void squared_angles(const PostRow& row, const double* drawn_z, RowValues& out) const {
    const glm::dvec2 start =
        reference_.world_from_post().apply(row.first.col, row.first.row) - glm::dvec2(eye_);
    const double dx = reference_.world_from_post().m[0];
    const double dy = reference_.world_from_post().m[3];
    for (int i = 0; i < Reference::kTilePosts; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double x = start.x + i * dx;
      const double y = start.y + i * dy;
      const double z = row.true_z[k] - eye_.z;
      const double delta = drawn_z[i] - row.true_z[k];
      out[k] = delta * delta / (x * x + y * y + z * z);
    }
  }

  const Reference& reference_;
  DrawnPosts drawn_;
  ScreenShift screen_;
  glm::dvec3 eye_;
  double alpha_;
};

}  // namespace

void Residuals::merge(const Residuals& other) {
  px.merge(other.px);
  max_angular_px = std::max(max_angular_px, other.max_angular_px);
  undrawn += other.undrawn;
}

Residuals measure_residuals(const mesh::Surface& surface, const Reference& reference,
                            const View& view, int threads) {
  const std::vector<int> tiles = reference.visible_tiles(view);
  const ResidualMeter meter(surface, reference, view, tiles);
  return sum_over_tiles<Residuals>(tiles, threads,
                                   [&](int tile, Residuals& sum) { meter.measure(tile, sum); });
}

void for_each_residual(const mesh::Surface& surface, const Reference& reference,
                       const std::function<void(const PostResidual&)>& visit) {
  const std::vector<int> tiles = reference.counted_tiles();
  const DrawnPosts drawn(surface, reference, tiles);
  PostHeights heights;
  for (const int tile : tiles) {
    drawn.read(tile, heights);
    for_each_row(reference, tile, [&](const PostRow& row) {
      for (int i = 0; i < Reference::kTilePosts; ++i) {
        const double true_z = row.true_z[static_cast<std::size_t>(i)];
        const double drawn_z = heights[row.offset + static_cast<std::size_t>(i)];
        const Post post{row.first.col + i, row.first.row};
        if (!std::isnan(true_z) && !std::isnan(drawn_z)) visit({post, true_z, drawn_z});
      }
    });
  }
}

}  // namespace arete::proof
