#include "arete/store/raster_build.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "arete/store/raster_pyramid.h"
#include "arete/store/work.h"

namespace arete::store {
namespace {

int texels_at(int level0, int level) {
  return (level0 + (1 << level) - 1) >> level;
}

std::size_t texel_index(const Texels& t, int row, int col) {
  return (static_cast<std::size_t>(row) * static_cast<std::size_t>(t.size) +
          static_cast<std::size_t>(col)) *
         static_cast<std::size_t>(t.channels);
}

Texels filled_tile(const RasterShape& shape) {
  const auto side = static_cast<std::size_t>(shape.tile_size);
  return {shape.tile_size, shape.channels,
          std::vector<std::uint8_t>(side * side * static_cast<std::size_t>(shape.channels),
                                    shape.fill)};
}

// Texels beyond the shape repeat its last column and row, so that means at its border are right.
void repeat_edges(const RasterShape& shape, TileId id, Texels& t) {
  const int level = static_cast<int>(id.level);
  const auto inside = [&](int level0, std::uint32_t tile) {
    return std::min(t.size, texels_at(level0, level) - static_cast<int>(tile) * t.size);
  };
  const int cols = inside(shape.width, id.x);
  const int rows = inside(shape.height, id.y);
  for (int r = 0; r < rows; ++r)
    for (int c = cols; c < t.size; ++c)
      std::copy_n(&t.bytes[texel_index(t, r, cols - 1)], t.channels,
                  &t.bytes[texel_index(t, r, c)]);
  for (int r = rows; r < t.size; ++r)
    std::copy_n(&t.bytes[texel_index(t, rows - 1, 0)], texel_index(t, 1, 0),
                &t.bytes[texel_index(t, r, 0)]);
}

void keep_tile(const RasterShape& shape, TileId id, Texels& texels, UnitWriter& unit) {
  repeat_edges(shape, id, texels);
  const bool all_fill =
      std::ranges::all_of(texels.bytes, [&shape](std::uint8_t b) { return b == shape.fill; });
  if (all_fill) return;
  thread_local std::vector<std::byte> raw;
  encode_texels(texels, raw);
  unit.add(id.key(), raw);
}

using FinerRows = std::array<std::unique_ptr<UnitReader>, 2>;

// Means of one child into its quarter of the parent.
void reduce_child(const RasterRecipe& recipe, const Texels& child, int quarter, Texels& parent) {
  const int half = parent.size / 2;
  const int row0 = quarter / 2 * half;
  const int col0 = quarter % 2 * half;
  for (int r = 0; r < half; ++r)
    for (int c = 0; c < half; ++c) {
      const std::uint8_t* north = &child.bytes[texel_index(child, 2 * r, 2 * c)];
      const std::uint8_t* south = &child.bytes[texel_index(child, 2 * r + 1, 2 * c)];
      recipe.mean({north, north + child.channels, south, south + child.channels},
                  &parent.bytes[texel_index(parent, row0 + r, col0 + c)]);
    }
}

void reduce_row(const RasterRecipe& recipe, TileId row, const FinerRows& finer, UnitWriter& unit) {
  const RasterShape& shape = recipe.shape;
  const int tiles = raster_tiles(shape.width, static_cast<int>(row.level), shape.tile_size);
  Texels child = filled_tile(shape);
  std::vector<std::byte> raw;
  for (int x = 0; x < tiles; ++x) {
    const TileId id{row.level, static_cast<std::uint32_t>(x), row.y};
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

}  // namespace

RasterShape pyramid_over(int width, int height) {
  RasterShape shape;
  shape.width = width;
  shape.height = height;
  shape.tile_size = kTexelTile;
  shape.levels = 1;
  while (raster_tiles(width, shape.levels - 1, kTexelTile) > 1 ||
         raster_tiles(height, shape.levels - 1, kTexelTile) > 1)
    ++shape.levels;
  return shape;
}

int raster_tiles(int texels, int level, int tile_size) {
  return (texels_at(texels, level) + tile_size - 1) / tile_size;
}

int make_raster_units(const RasterRecipe& recipe, const UnitFolder& units,
                      const BuildContext& context) {
  const RasterShape& shape = recipe.shape;
  const int rows0 = raster_tiles(shape.height, 0, shape.tile_size);
  for_each_unit(context, recipe.step, rows0, recipe.bytes_each, [&](int y) {
    units.make(y, [&](UnitWriter& unit) {
      recipe.make_row(y, [&](int x, Texels& texels) {
        keep_tile(shape, {0, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)}, texels,
                  unit);
      });
    });
  });
  int finer = 0;
  int finer_rows = rows0;
  for (int level = 1; level < shape.levels; ++level) {
    const int first = finer + finer_rows;
    const int rows = raster_tiles(shape.height, level, shape.tile_size);
    for_each_unit(context, recipe.step, rows, 0, [&](int y) {
      units.make(first + y, [&](UnitWriter& unit) {
        FinerRows below;
        for (int half = 0; half < 2; ++half)
          if (2 * y + half < finer_rows)
            below[static_cast<std::size_t>(half)] = units.open(finer + 2 * y + half);
        const TileId row{static_cast<std::uint32_t>(level), 0, static_cast<std::uint32_t>(y)};
        reduce_row(recipe, row, below, unit);
      });
    });
    finer = first;
    finer_rows = rows;
  }
  return finer + finer_rows;
}

}  // namespace arete::store
