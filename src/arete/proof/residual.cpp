#include "arete/proof/residual.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "arete/core/screen_error.h"
#include "arete/proof/drawn_posts.h"
#include "arete/proof/screen_shift.h"
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
        alpha_(pixel_scale(view, ErrorScale::kAngular)) {}

  void measure(int tile, Residuals& sum) const {
    PostHeights heights;
    drawn_.read(tile, heights);
    for_each_post(reference_, tile, [&](Post p, std::size_t i) { add(p, heights[i], sum); });
  }

 private:
  void add(Post p, double drawn_z, Residuals& sum) const {
    const double true_z = double{reference_.dem()[p]};
    const glm::dvec3 c = screen_.clip(p, true_z);
    if (!screen_.inside(c)) return;
    if (std::isnan(drawn_z)) {
      ++sum.undrawn;
      return;
    }
    const double dz = drawn_z - true_z;
    sum.px.add_squared(screen_.squared_px(c, dz));
    const glm::dvec3 ray =
        glm::dvec3(reference_.world_from_post().apply(p.col, p.row), true_z) - eye_;
    const double angle = alpha_ * dz;
    const double distance2 = glm::dot(ray, ray);
    if (angle * angle > sum.max_angular_px * sum.max_angular_px * distance2) {
      sum.max_angular_px = std::sqrt(angle * angle / distance2);
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
    for_each_post(reference, tile, [&](Post p, std::size_t i) {
      if (!std::isnan(heights[i])) visit({p, double{reference.dem()[p]}, heights[i]});
    });
  }
}

}  // namespace arete::proof
