#include "arete/lod/bintree/post_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "arete/core/error.h"
#include "arete/store/pyramid_shape.h"

namespace arete::lod::bintree {
namespace {

using store::kTileCells;

store::PyramidShape shape_of(const store::Terrain& terrain) {
  return {terrain.manifest().cols, terrain.manifest().rows};
}

store::TileReader tiles_of(const store::Terrain& terrain) {
  return [&terrain, held = std::shared_ptr<const store::HeightTile>()](TileId id) mutable {
    held = terrain.heights(id, store::Fetch::Wait);
    return held.get();
  };
}

std::int32_t middle_count(const store::Manifest& m) {
  return static_cast<std::int32_t>(
      std::lround(((m.z_min + m.z_max) / 2 - m.offset_m) / m.quantum_m));
}

// The post's count in a tile of the level that holds it, else kAbsent.
std::int32_t count_in_level(const store::Terrain& terrain, int level, Post post) {
  const auto tiles = [&](int p, int n) {
    const int last = n * kTileCells;
    const int q = std::min(p, last);
    return std::pair(std::max(0, (q - 1) / kTileCells), std::min(q / kTileCells, n - 1));
  };
  const auto [x0, x1] = tiles(post.col, terrain.tiles_x(level));
  const auto [y0, y1] = tiles(post.row, terrain.tiles_y(level));
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const auto tile =
          terrain.heights({static_cast<std::uint32_t>(level), static_cast<std::uint32_t>(x),
                           static_cast<std::uint32_t>(y)},
                          store::Fetch::Wait);
      if (!tile) continue;
      const int col = std::min(post.col - x * kTileCells, kTileCells);
      const int row = std::min(post.row - y * kTileCells, kTileCells);
      return tile->counts[static_cast<std::size_t>(row * store::kTilePosts + col)];
    }
  }
  return store::kAbsent;
}

// Tiles of all levels that hold the post agree on it.
std::int32_t count_in_any_level(const store::Terrain& terrain, Post level0) {
  for (int level = 0; level < terrain.levels(); ++level) {
    if (((level0.col | level0.row) & ((1 << level) - 1)) != 0) break;
    const std::int32_t count =
        count_in_level(terrain, level, {level0.col >> level, level0.row >> level});
    if (count != store::kAbsent) return count;
  }
  return middle_count(terrain.manifest());
}

// drawable[c] = 1 when the cell between posts c and c + 1 of two rows is.
void find_drawable(const std::uint8_t* north, const std::uint8_t* south, int cells,
                   std::uint8_t* drawable) {
  for (int c = 0; c < cells; ++c) drawable[c] = north[c] & north[c + 1] & south[c] & south[c + 1];
}

}  // namespace

void PostRows::load(const store::Terrain& terrain, const PostRect& rect) {
  const store::PyramidShape shape = shape_of(terrain);
  const PostRect around{std::max(rect.col0 - 1, 0), std::max(rect.row0 - 1, 0),
                        std::min(rect.col1 + 1, shape.cols), std::min(rect.row1 + 1, shape.rows)};
  rect_ = {std::max(rect.col0, 0), std::max(rect.row0, 0), std::min(rect.col1, shape.cols),
           std::min(rect.row1, shape.rows)};
  if (rect_.empty()) return;
  patch_.load(shape, 0, around, store::BeyondGrid::Drop, tiles_of(terrain));
  require_undamaged(terrain);
  const auto width = static_cast<std::size_t>(rect_.col1 - rect_.col0);
  z_.resize(width * static_cast<std::size_t>(rect_.row1 - rect_.row0));
  for (int r = rect_.row0; r < rect_.row1; ++r) {
    double* z = z_.data() + static_cast<std::size_t>(r - rect_.row0) * width;
    const std::int32_t* counts = patch_.counts(r, rect_.col0);
    for (std::size_t c = 0; c < width; ++c) z[c] = counts[c];
    drop_undrawable(r, z);
  }
}

void PostRows::drop_undrawable(int row, double* z) {
  const PostRect& held = patch_.rect();
  const int posts = held.col1 - held.col0;
  const std::uint8_t* valid = patch_.valid(row, held.col0);
  const bool first = row == held.row0;
  const bool last = row + 1 == held.row1;
  const std::uint8_t* north = first ? nullptr : patch_.valid(row - 1, held.col0);
  const std::uint8_t* south = last ? nullptr : patch_.valid(row + 1, held.col0);
  const auto all = [posts](const std::uint8_t* v) {
    return v != nullptr && std::find(v, v + posts, std::uint8_t{0}) == v + posts;
  };
  if (posts > 1 && all(valid) && (all(north) || all(south))) return;
  // Cells -1 and posts - 1 lie outside what is held, or outside the grid.
  above_.assign(static_cast<std::size_t>(posts) + 1, 0);
  below_.assign(static_cast<std::size_t>(posts) + 1, 0);
  if (north != nullptr) find_drawable(north, valid, posts - 1, above_.data() + 1);
  if (south != nullptr) find_drawable(valid, south, posts - 1, below_.data() + 1);
  for (int c = rect_.col0; c < rect_.col1; ++c) {
    const auto i = static_cast<std::size_t>(c - held.col0);
    if ((above_[i] | above_[i + 1] | below_[i] | below_[i + 1]) == 0)
      z[c - rect_.col0] = std::numeric_limits<double>::quiet_NaN();
  }
}

void load_lattice(const store::Terrain& terrain, int level, const PostRect& rect,
                  std::vector<std::int32_t>& counts) {
  const auto width = static_cast<std::size_t>(rect.col1 - rect.col0);
  counts.resize(width * static_cast<std::size_t>(rect.row1 - rect.row0));
  const PostRect tiles{0, 0, terrain.tiles_x(level) * kTileCells + 1,
                       terrain.tiles_y(level) * kTileCells + 1};
  const PostRect inside{std::min(rect.col0, tiles.col1 - 1), std::min(rect.row0, tiles.row1 - 1),
                        std::min(rect.col1, tiles.col1), std::min(rect.row1, tiles.row1)};
  store::HeightPatch patch;
  patch.load(shape_of(terrain), level, inside, store::BeyondGrid::Repeat, tiles_of(terrain));
  require_undamaged(terrain);
  // Level 0 alone decides about the two finest levels of vertices: one that no level-0 tile holds
  // is no corner of a triangle with a drawable post.
  const std::int32_t middle = middle_count(terrain.manifest());
  std::size_t i = 0;
  for (int r = rect.row0; r < rect.row1; ++r) {
    const std::int32_t* row = patch.counts(std::min(r, tiles.row1 - 1), inside.col0);
    for (int c = rect.col0; c < rect.col1; ++c, ++i) {
      counts[i] = row[std::min(c, tiles.col1 - 1) - inside.col0];
      if (counts[i] == store::kAbsent)
        counts[i] = level == 0 ? middle : count_in_any_level(terrain, {c << level, r << level});
    }
  }
}

void require_undamaged(const store::Terrain& terrain) {
  if (terrain.cache_stats().damaged > 0)
    throw Error(ErrorCode::Corrupt,
                terrain.name() + ": a height tile is damaged: build it again with --force");
}

}  // namespace arete::lod::bintree
