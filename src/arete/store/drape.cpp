#include "arete/store/drape.h"

#include <atomic>
#include <vector>

#include "arete/store/raster_build.h"
#include "arete/store/raster_pyramid.h"
#include "arete/store/work.h"

namespace arete::store {
namespace {

constexpr const char* kName = "drape";

struct TileRow {
  std::uint32_t level = 0, y = 0;
};

std::vector<TileRow> rows_of(const RasterShape& shape) {
  std::vector<TileRow> rows;
  for (int level = 0; level < shape.levels; ++level)
    for (int y = 0; y < raster_tiles(shape.height, level, shape.tile_size); ++y)
      rows.push_back({static_cast<std::uint32_t>(level), static_cast<std::uint32_t>(y)});
  return rows;
}

void copy_row(const RasterSource& from, const RasterShape& shape, TileRow row, UnitWriter& unit) {
  std::vector<std::byte> raw;
  const int tiles = raster_tiles(shape.width, static_cast<int>(row.level), shape.tile_size);
  for (int x = 0; x < tiles; ++x) {
    const TileId id{row.level, static_cast<std::uint32_t>(x), row.y};
    const Texels texels = from.read(id);
    if (is_fill(shape, texels)) continue;
    encode_texels(texels, raw);
    unit.add(id.key(), raw);
  }
}

// The same texels at level 0, from which all other levels follow.
bool holds(const SegmentReader& segment, const RasterSource& drape) {
  std::atomic<std::uint64_t> damaged{0};
  const auto kept = open_raster(segment, &damaged);
  const RasterShape shape = drape.shape();
  const auto across = static_cast<std::uint32_t>(raster_tiles(shape.width, 0, shape.tile_size));
  const auto down = static_cast<std::uint32_t>(raster_tiles(shape.height, 0, shape.tile_size));
  for (TileId id; id.y < down; ++id.y)
    for (id.x = 0; id.x < across; ++id.x)
      if (kept->read(id).bytes != drape.read(id).bytes) return false;
  return damaged == 0;
}

}  // namespace

void write_drape(const RasterSource& drape, StoreBuilder& builder) {
  const RasterShape shape = drape.shape();
  const std::string params = raster_params(shape, kName);
  if (const auto finished = builder.find_finished(kName);
      finished && finished->params() == params && holds(*finished, drape))
    return builder.record(*finished);
  const UnitFolder folder = builder.units(kName, params);
  const std::vector<TileRow> rows = rows_of(shape);
  for_each_unit(builder.context(), kName, static_cast<int>(rows.size()), 0, [&](int u) {
    folder.make(u, [&](UnitWriter& unit) {
      copy_row(drape, shape, rows[static_cast<std::size_t>(u)], unit);
    });
  });
  builder.assemble_all(folder, static_cast<int>(rows.size()), kName, params);
}

}  // namespace arete::store
