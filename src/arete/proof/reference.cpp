#include "arete/proof/reference.h"

#include <algorithm>
#include <array>
#include <limits>

#include "arete/core/parallel.h"

namespace arete::proof {
namespace {

int tiles_along(int posts) {
  return (posts + Reference::kTilePosts - 1) / Reference::kTilePosts;
}

}  // namespace

Reference::Reference(const Heightfield& dem, int threads)
    : dem_(dem),
      world_from_post_(dem.georef().world_from_post),
      tile_cols_(tiles_along(dem.cols())),
      tile_rows_(tiles_along(dem.rows())),
      tiles_(static_cast<std::size_t>(tile_cols_) * static_cast<std::size_t>(tile_rows_)) {
  parallel_for(threads, tile_rows_, [&](int row) {
    for (int t = row * tile_cols_; t < (row + 1) * tile_cols_; ++t) {
      tiles_[static_cast<std::size_t>(t)] = scan(t);
    }
  });
}

bool Reference::counts(Post p) const {
  if (!dem_.valid(p)) return false;
  for (int r = std::max(p.row - 1, 0); r <= std::min(p.row, dem_.rows() - 2); ++r) {
    for (int c = std::max(p.col - 1, 0); c <= std::min(p.col, dem_.cols() - 2); ++c) {
      if (dem_.drawable({c, r})) return true;
    }
  }
  return false;
}

PostRect Reference::posts_of(int tile) const {
  const int c = tile % tile_cols_ * kTilePosts;
  const int r = tile / tile_cols_ * kTilePosts;
  return {c, r, std::min(c + kTilePosts, dem_.cols()), std::min(r + kTilePosts, dem_.rows())};
}

Reference::Tile Reference::scan(int tile) const {
  Tile out{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(), false};
  const PostRect rect = posts_of(tile);
  for (int r = rect.row0; r < rect.row1; ++r) {
    for (int c = rect.col0; c < rect.col1; ++c) {
      const float z = dem_[{c, r}];
      if (std::isnan(z)) continue;
      if (!counts({c, r})) {
        out.stray = true;
        continue;
      }
      out.lo = std::min(out.lo, z);
      out.hi = std::max(out.hi, z);
    }
  }
  return out;
}

void Reference::read_row(int tile, int r, std::array<double, kTilePosts>& z) const {
  const PostRect rect = posts_of(tile);
  const bool stray = tiles_[static_cast<std::size_t>(tile)].stray;
  const float* const posts = dem_.row(r).data() + rect.col0;
  const auto count = static_cast<std::size_t>(rect.col1 - rect.col0);
  for (std::size_t i = 0; i < count; ++i) z[i] = double{posts[i]};
  for (std::size_t i = count; i < z.size(); ++i) z[i] = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; stray && i < count; ++i) {
    if (!counts({rect.col0 + static_cast<std::int32_t>(i), r})) {
      z[i] = std::numeric_limits<double>::quiet_NaN();
    }
  }
}

std::vector<int> Reference::counted_tiles() const {
  std::vector<int> out;
  for (int t = 0; t < tiles(); ++t) {
    const Tile& tile = tiles_[static_cast<std::size_t>(t)];
    if (tile.lo <= tile.hi) out.push_back(t);
  }
  return out;
}

std::vector<int> Reference::visible_tiles(const View& view) const {
  const std::array<glm::dvec4, 5> planes = frustum_planes(view);
  std::vector<int> out;
  for (const int t : counted_tiles()) {
    const PostRect p = posts_of(t);
    glm::dvec2 lo(std::numeric_limits<double>::infinity());
    glm::dvec2 hi = -lo;
    for (const int row : {p.row0, p.row1 - 1}) {
      for (const int col : {p.col0, p.col1 - 1}) {
        const glm::dvec2 corner = world_from_post_.apply(col, row);
        lo = glm::min(lo, corner);
        hi = glm::max(hi, corner);
      }
    }
    const Tile& tile = tiles_[static_cast<std::size_t>(t)];
    if (may_see(planes, {lo, double{tile.lo}}, {hi, double{tile.hi}})) out.push_back(t);
  }
  return out;
}

}  // namespace arete::proof
