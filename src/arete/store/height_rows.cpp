#include "arete/store/height_rows.h"

#include <algorithm>
#include <limits>

#include "arete/core/error.h"
#include "arete/store/height_codec.h"

namespace arete::store {
namespace {

class HeightRows : public HeightSource {
 public:
  HeightRows(const SegmentReader& heights, const Manifest& manifest)
      : manifest_(manifest), shape_{manifest.cols, manifest.rows}, read_(tiles_of(heights)) {}

  int cols() const override { return manifest_.cols; }
  int rows() const override { return manifest_.rows; }
  Georef georef() const override { return manifest_.georef; }
  HeightLattice lattice() const override { return {true, manifest_.quantum_m, manifest_.offset_m}; }
  std::string description() const override { return manifest_.source; }

  void read_row(int r, std::span<float> row) override {
    const PostRect& loaded = patch_.rect();
    if (r < loaded.row0 || r >= loaded.row1) load(r);
    const std::int32_t* counts = patch_.counts(r, 0);
    const std::uint8_t* valid = patch_.valid(r, 0);
    for (std::size_t c = 0; c < row.size(); ++c)
      row[c] = valid[c] != 0
                   ? static_cast<float>(manifest_.offset_m + manifest_.quantum_m * counts[c])
                   : std::numeric_limits<float>::quiet_NaN();
  }

 private:
  // The whole row of tiles, in memory that only a complete load marks as loaded.
  void load(int r) {
    const int first = std::min(r / kTileCells, shape_.tiles_y(0) - 1) * kTileCells;
    HeightPatch patch;
    std::swap(patch, patch_);
    patch.load(shape_, 0, {0, first, manifest_.cols, std::min(first + kTilePosts, manifest_.rows)},
               BeyondGrid::Drop, read_);
    std::swap(patch, patch_);
  }

  const Manifest& manifest_;
  PyramidShape shape_;
  TileReader read_;
  HeightPatch patch_;
};

}  // namespace

TileReader tiles_of(const SegmentReader& heights) {
  return [&heights](TileId id) -> const HeightTile* {
    thread_local std::vector<std::byte> raw;
    thread_local HeightTile tile;
    if (heights.read(id.key(), raw) == 0) return nullptr;
    try {
      decode_tile(raw, tile);
    } catch (const Error& error) {
      throw Error(error.code(), heights.label() + ": " + error.what());
    }
    return &tile;
  };
}

std::unique_ptr<HeightSource> make_height_rows(const SegmentReader& heights,
                                               const Manifest& manifest) {
  return std::make_unique<HeightRows>(heights, manifest);
}

}  // namespace arete::store
