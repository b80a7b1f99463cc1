#include "arete/store/heights_build.h"

#include <map>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "arete/core/error.h"
#include "arete/store/height_codec.h"
#include "arete/store/height_levels.h"
#include "arete/store/import.h"
#include "arete/store/work.h"

namespace arete::store {
namespace {

constexpr const char* kName = "heights";

// What the import found out, kept as the segment's params so that a resumed build knows it.
std::string heights_params(const Manifest& m) {
  nlohmann::ordered_json json;
  json["cols"] = m.cols;
  json["rows"] = m.rows;
  json["quantum_m"] = m.quantum_m;
  json["offset_m"] = m.offset_m;
  json["z_min"] = m.z_min;
  json["z_max"] = m.z_max;
  json["max_store_error_m"] = m.max_store_error_m;
  json["nodata_share"] = m.nodata_share;
  json["drawable_cells"] = m.drawable_cells;
  return json.dump();
}

void take_params(const std::string& params, Manifest& m) {
  const auto json = nlohmann::json::parse(params);
  json.at("quantum_m").get_to(m.quantum_m);
  json.at("offset_m").get_to(m.offset_m);
  json.at("z_min").get_to(m.z_min);
  json.at("z_max").get_to(m.z_max);
  json.at("max_store_error_m").get_to(m.max_store_error_m);
  json.at("nodata_share").get_to(m.nodata_share);
  json.at("drawable_cells").get_to(m.drawable_cells);
}

// The bands of level 0 and what they add up to.
struct Import {
  Lattice lattice;
  RowStats stats;
  std::uint64_t drawable_cells = 0;
  bool has_holes = false;
  std::vector<UnitRef> bands;
};

void describe(const Import& import, Manifest& m) {
  const double posts = static_cast<double>(m.cols) * m.rows;
  const bool any = import.stats.valid > 0;
  m.quantum_m = import.lattice.quantum_m;
  m.offset_m = import.lattice.offset_m;
  m.z_min = any ? m.offset_m + m.quantum_m * import.stats.count_min : 0;
  m.z_max = any ? m.offset_m + m.quantum_m * import.stats.count_max : 0;
  m.max_store_error_m = static_cast<double>(import.stats.max_error_m);
  m.nodata_share = 1 - static_cast<double>(import.stats.valid) / posts;
  m.drawable_cells = import.drawable_cells;
}

class HeightsBuild {
 public:
  HeightsBuild(HeightSource& source, StoreBuilder& builder)
      : source_(source),
        builder_(builder),
        shape_{source.cols(), source.rows()},
        grid_(shape_.cols, shape_.rows) {}

  void run() {
    import_rows();
    if (import_.has_holes) fill_holes();
    std::vector<UnitRef> units = import_.bands;
    describe(import_, builder_.manifest);
    const UnitFolder folder = builder_.units("levels", content("levels"));
    int next = 0;
    for (int level = 1; level < shape_.levels(); ++level) {
      const int rows = shape_.tiles_y(level);
      const auto fine_rows = static_cast<std::size_t>(shape_.tiles_y(level - 1));
      make_level(level, std::span(units).last(fine_rows), folder, next);
      for (int y = 0; y < rows; ++y) units.push_back({folder, next + y});
      next += rows;
    }
    builder_.assemble(kName, heights_params(builder_.manifest), units);
    for (const char* name : {"import", "filled", "levels"}) builder_.units(name, {}).clear();
  }

 private:
  // Rows of tiles of one level in their units, opened as they are met; for one thread.
  struct UnitRows {
    std::span<const UnitRef> refs;
    std::map<std::uint32_t, std::unique_ptr<UnitReader>> open = {};
    std::vector<std::byte> raw = {};
    HeightTile tile = {};
    const HeightTile* read(TileId id) {
      auto& unit = open[id.y];
      if (!unit) unit = refs[id.y].open();
      if (!unit->read(id.key(), raw)) return nullptr;
      decode_tile(raw, tile);
      return &tile;
    }
  };

  std::string content(const char* what) const {
    return fmt::format("{} {} {} {} {}", what, shape_.cols, shape_.rows, import_.lattice.quantum_m,
                       import_.lattice.offset_m);
  }

  void import_rows() {
    import_.lattice = first_lattice(source_.lattice());
    if (!try_import()) {
      import_.lattice = scan_for_lattice(source_, builder_.context());
      if (!try_import())
        throw Error(ErrorCode::InvalidInput,
                    source_.description() + ": changed while it was read: build it again");
    }
    for (int y = 0; y < shape_.tiles_y(0); ++y) {
      const auto summary =
          BandSummary::from_bytes(import_.bands[static_cast<std::size_t>(y)].open()->aux());
      import_.stats.merge(summary.stats);
      import_.drawable_cells += summary.drawable_cells;
      import_.has_holes = import_.has_holes || summary.has_holes != 0;
      grid_.set_rows(y * (kTileCells / grid_.cell_posts()), summary.fill_cells);
    }
  }

  bool try_import() {
    const UnitFolder folder = builder_.units("import", content("import"));
    if (!import_bands(source_, import_.lattice, grid_.cell_posts(), folder, builder_.context()))
      return false;
    for (int y = 0; y < shape_.tiles_y(0); ++y) import_.bands.push_back({folder, y});
    return true;
  }

  void fill_holes() {
    grid_.finish();
    const UnitFolder folder = builder_.units("filled", content("filled"));
    for_each_unit(builder_.context(), "fill holes", shape_.tiles_y(0), 0, [&](int y) {
      UnitRef& band = import_.bands[static_cast<std::size_t>(y)];
      const auto imported = band.open();
      if (BandSummary::from_bytes(imported->aux()).has_holes == 0) return;
      folder.make(y, [&](UnitWriter& unit) { fill_band(shape_, grid_, *imported, unit); });
      band = {folder, y};
    });
  }

  void make_level(int level, std::span<const UnitRef> finer, const UnitFolder& folder,
                  int first) const {
    for_each_unit(builder_.context(), "levels", shape_.tiles_y(level), kLevelRowBytes, [&](int y) {
      const TileId id{static_cast<std::uint32_t>(level), 0, static_cast<std::uint32_t>(y)};
      UnitRows rows{finer};
      folder.make(first + y, [&](UnitWriter& unit) {
        store_level_row(
            shape_, id, [&rows](TileId tile) { return rows.read(tile); },
            import_.has_holes ? &grid_ : nullptr, unit);
      });
    });
  }

  HeightSource& source_;
  StoreBuilder& builder_;
  PyramidShape shape_;
  FillGrid grid_;
  Import import_;
};

}  // namespace

void build_heights(HeightSource& source, StoreBuilder& builder) {
  builder.manifest.cols = source.cols();
  builder.manifest.rows = source.rows();
  if (const auto finished = builder.find_finished(kName)) {
    take_params(finished->params(), builder.manifest);
    return builder.record(*finished);
  }
  HeightsBuild(source, builder).run();
}

}  // namespace arete::store
