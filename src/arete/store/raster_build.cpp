#include "arete/store/raster_build.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "arete/store/raster_pyramid.h"
#include "arete/store/work.h"

namespace arete::store {
namespace {

// Level-1 tiles made from one patch of heights: wide patches waste little on the apron.
constexpr int kTilesAPatch = 8;

std::size_t texel_index(const Texels& t, int row, int col) {
  return (static_cast<std::size_t>(row) * static_cast<std::size_t>(t.size) +
          static_cast<std::size_t>(col)) *
         static_cast<std::size_t>(t.channels);
}

struct Extent {
  int cols = 0, rows = 0;
};

// Texels of the tile within the shape.
Extent extent_of(const RasterShape& shape, TileId id) {
  const auto inside = [&](int level0, std::uint32_t tile) {
    const int texels = (level0 + (1 << id.level) - 1) >> id.level;
    return std::min(shape.tile_size, texels - static_cast<int>(tile) * shape.tile_size);
  };
  return {inside(shape.width, id.x), inside(shape.height, id.y)};
}

// Texels beyond the shape repeat its last column and row, so that means at its border are right.
void repeat_edges(const RasterShape& shape, TileId id, Texels& t) {
  const Extent in = extent_of(shape, id);
  for (int r = 0; r < in.rows; ++r)
    for (int c = in.cols; c < t.size; ++c)
      std::copy_n(&t.bytes[texel_index(t, r, in.cols - 1)], t.channels,
                  &t.bytes[texel_index(t, r, c)]);
  for (int r = in.rows; r < t.size; ++r)
    std::copy_n(&t.bytes[texel_index(t, in.rows - 1, 0)], texel_index(t, 1, 0),
                &t.bytes[texel_index(t, r, 0)]);
}

void keep_tile(const RasterShape& shape, TileId id, Texels& texels, UnitWriter& unit) {
  repeat_edges(shape, id, texels);
  if (is_fill(shape, texels)) return;
  thread_local std::vector<std::byte> raw;
  encode_texels(texels, raw);
  unit.add(id.key(), raw);
}

// The mean of two rows of `count` * 2 texels each.
void mean_row(const RasterRecipe& recipe, const std::uint8_t* north, const std::uint8_t* south,
              int count, std::uint8_t* to) {
  const int n = recipe.shape.channels;
  for (int c = 0; c < count; ++c, north += 2 * n, south += 2 * n, to += n)
    recipe.mean({north, north + n, south, south + n}, to);
}

// Level-1 tiles [x0, x1) of row y straight from the heights.
void store_level1(const RasterRecipe& recipe, const PyramidShape& shape, TileId row,
                  std::uint32_t x1, const TileReader& heights, UnitWriter& unit) {
  thread_local HeightPatch patch;
  constexpr int kSpan = 2 * kTexelTile;
  const int row0 = static_cast<int>(row.y) * kSpan;
  patch.load(shape, 0,
             {static_cast<int>(row.x) * kSpan - recipe.apron, row0 - recipe.apron,
              static_cast<int>(x1) * kSpan + recipe.apron, row0 + kSpan + recipe.apron},
             BeyondGrid::Drop, heights);
  const auto row_bytes = static_cast<std::size_t>(kSpan * recipe.shape.channels);
  std::vector<std::uint8_t> pair(2 * row_bytes);
  Texels texels = filled_tile(recipe.shape);
  for (TileId id = row; id.x < x1; ++id.x) {
    const int col0 = static_cast<int>(id.x) * kSpan;
    const Extent in = extent_of(recipe.shape, id);
    for (int r = 0; r < in.rows; ++r) {
      for (int half = 0; half < 2; ++half) {
        // The last row or column of an odd grid counts twice.
        const int post_row = std::min(row0 + 2 * r + half, shape.rows - 1);
        std::uint8_t* to = &pair[static_cast<std::size_t>(half) * row_bytes];
        const int cols = std::min(kSpan, shape.cols - col0);
        recipe.make_texels(patch, {col0, post_row}, cols, to);
        if (cols % 2 != 0)
          std::copy_n(to + (cols - 1) * recipe.shape.channels, recipe.shape.channels,
                      to + cols * recipe.shape.channels);
      }
      mean_row(recipe, pair.data(), pair.data() + row_bytes, in.cols,
               &texels.bytes[texel_index(texels, r, 0)]);
    }
    keep_tile(recipe.shape, id, texels, unit);
  }
}

using FinerRows = std::array<std::unique_ptr<UnitReader>, 2>;

void reduce_child(const RasterRecipe& recipe, const Texels& child, int quarter, Texels& parent) {
  const int half = parent.size / 2;
  for (int r = 0; r < half; ++r)
    mean_row(recipe, &child.bytes[texel_index(child, 2 * r, 0)],
             &child.bytes[texel_index(child, 2 * r + 1, 0)], half,
             &parent.bytes[texel_index(parent, quarter / 2 * half + r, quarter % 2 * half)]);
}

void reduce_row(const RasterRecipe& recipe, TileId id, const FinerRows& finer, UnitWriter& unit) {
  const RasterShape& shape = recipe.shape;
  const int tiles = raster_tiles(shape.width, static_cast<int>(id.level), shape.tile_size);
  Texels child = filled_tile(shape);
  std::vector<std::byte> raw;
  for (; id.x < static_cast<std::uint32_t>(tiles); ++id.x) {
    Texels parent = filled_tile(shape);
    bool any = false;
    for (int quarter = 0; quarter < 4; ++quarter) {
      const auto& reader = finer[static_cast<std::size_t>(quarter) / 2];
      if (!reader || !reader->read(id.child(quarter).key(), raw)) continue;
      decode_texels(raw, child);
      reduce_child(recipe, child, quarter, parent);
      any = true;
    }
    if (any) keep_tile(shape, id, parent, unit);
  }
}

std::size_t patch_bytes(const RasterRecipe& recipe) {
  constexpr int kSpan = 2 * kTexelTile;
  return HeightPatch::bytes(kTilesAPatch * kSpan + 2 * recipe.apron, kSpan + 2 * recipe.apron);
}

}  // namespace

bool is_fill(const RasterShape& shape, const Texels& texels) {
  return std::ranges::all_of(texels.bytes, [&](std::uint8_t b) { return b == shape.fill; });
}

int make_raster_units(const RasterRecipe& recipe, const PyramidShape& shape,
                      const TileReader& heights, const UnitFolder& units,
                      const BuildContext& context) {
  int first = 0;
  for (int level = 1; level < recipe.shape.levels; ++level) {
    const int rows = raster_tiles(recipe.shape.height, level, kTexelTile);
    const int finer_rows = raster_tiles(recipe.shape.height, level - 1, kTexelTile);
    const int finer = first - finer_rows;  // unit of the finer level's row 0, for level >= 2
    const auto tiles =
        static_cast<std::uint32_t>(raster_tiles(recipe.shape.width, level, kTexelTile));
    for_each_unit(context, recipe.step, rows, patch_bytes(recipe), [&](int y) {
      units.make(first + y, [&](UnitWriter& unit) {
        TileId id{static_cast<std::uint32_t>(level), 0, static_cast<std::uint32_t>(y)};
        for (; level == 1 && id.x < tiles; id.x += kTilesAPatch)
          store_level1(recipe, shape, id, std::min(id.x + kTilesAPatch, tiles), heights, unit);
        if (level == 1) return;
        FinerRows below;
        for (int half = 0; half < 2; ++half)
          if (2 * y + half < finer_rows)
            below[static_cast<std::size_t>(half)] = units.open(finer + 2 * y + half);
        reduce_row(recipe, id, below, unit);
      });
    });
    first += rows;
  }
  return first;
}

}  // namespace arete::store
