#include "arete/proof/pop.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <vector>

#include "arete/proof/drawn_posts.h"
#include "arete/proof/post_row.h"
#include "arete/proof/sum_over_tiles.h"

namespace arete::proof {
namespace {

std::vector<int> seen_in_both(const FramePair& pair, const Reference& reference) {
  const std::vector<int> a = reference.visible_tiles(pair.view_before);
  const std::vector<int> b = reference.visible_tiles(pair.view_after);
  std::vector<int> both;
  std::ranges::set_intersection(a, b, std::back_inserter(both));
  return both;
}

double distance_to_box(glm::dvec3 p, glm::dvec3 lo, glm::dvec3 hi) {
  return glm::length(glm::max(glm::max(lo - p, p - hi), glm::dvec3(0)));
}

}  // namespace

PixelHistogram measure_pops(const FramePair& pair, const Reference& reference, int threads) {
  const std::vector<int> tiles = seen_in_both(pair, reference);
  const DrawnPosts before(pair.before, reference, tiles);
  const DrawnPosts after(pair.after, reference, tiles);
  const ScreenShift earlier(pair.view_before, reference.world_from_post());
  const ScreenShift later(pair.view_after, reference.world_from_post());
  return sum_over_tiles<PixelHistogram>(tiles, threads, [&](int tile, PixelHistogram& sum) {
    PostHeights z_before;
    PostHeights z_after;
    before.read(tile, z_before);
    after.read(tile, z_after);
    for_each_row(reference, tile, [&](const PostRow& row) {
      RowValues squared;
      later.squared_px(row.first, &z_after[row.offset], &z_before[row.offset], squared);
      later.drop_unseen(row.first, row.true_z, squared);
      earlier.drop_unseen(row.first, row.true_z, squared);
      for (const double s : squared) {
        if (s >= 0) sum.add_squared(s);  // NaN: not drawn in both
      }
    });
  });
}

double nearest_batch_m(const DrawList& list, const BlockSource& blocks,
                       const Affine2& world_from_post, glm::dvec3 eye) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const DrawBatch& batch : list.batches) {
    const std::span<const Vertex> vertices = mesh::vertices_of(batch, list, blocks);
    glm::dvec3 lo(std::numeric_limits<double>::infinity());
    glm::dvec3 hi = -lo;
    for (const std::uint32_t i : mesh::indices_of(batch, list, blocks)) {
      const mesh::SurfaceVertex v = mesh::drawn_vertex(vertices[i], batch);
      const glm::dvec2 plan =
          world_from_post.apply(double{v.dcol} + v.post.col, double{v.drow} + v.post.row);
      lo = glm::min(lo, {plan, double{v.z}});
      hi = glm::max(hi, {plan, double{v.z}});
    }
    nearest = std::min(nearest, distance_to_box(eye, lo, hi));
  }
  return nearest;
}

double relative_motion(const View& before, const View& after, ErrorScale scale, double nearest_m) {
  const double moved = glm::length(after.eye - before.eye);
  const double alpha = pixel_scale(after, scale);
  const double zoomed = std::abs(alpha - pixel_scale(before, scale)) / alpha;
  return (moved == 0 ? 0 : moved / nearest_m) + zoomed;
}

double relative_change(double before, double after) {
  const double larger = std::max(before, after);
  if (std::isinf(larger)) return larger;
  return larger == 0 ? 0 : std::abs(after - before) / larger;
}

double pop_share(double pop_px, double claim_px, double motion) {
  if (pop_px == 0 || std::isinf(claim_px)) return 0;
  if (claim_px == 0) return std::numeric_limits<double>::infinity();  // whatever the motion
  if (std::isinf(motion)) return 0;
  return pop_px / (claim_px * motion);
}

}  // namespace arete::proof
