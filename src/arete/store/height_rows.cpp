#include "arete/store/height_rows.h"

#include <algorithm>
#include <cmath>

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
    const int y = std::min(r / kTileCells, shape_.tiles_y(0) - 1);
    if (y != loaded_) {
      loaded_ = -1;
      load_band(shape_, {0, 0, static_cast<std::uint32_t>(y)}, read_, band_);
      loaded_ = y;
    }
    const std::int32_t* counts = band_.row(r - y * kTileCells);
    const std::uint8_t* valid = band_.valid_row(r - y * kTileCells);
    for (std::size_t c = 0; c < row.size(); ++c)
      row[c] = valid[c] != 0
                   ? static_cast<float>(manifest_.offset_m + manifest_.quantum_m * counts[c])
                   : std::numeric_limits<float>::quiet_NaN();
  }

 private:
  const Manifest& manifest_;
  PyramidShape shape_;
  TileReader read_;
  HeightBand band_;
  int loaded_ = -1;
};

}  // namespace

TileReader tiles_of(const SegmentReader& heights) {
  return [&heights](TileId id, HeightTile& tile) {
    thread_local std::vector<std::byte> raw;
    if (heights.read(id.key(), raw) == 0) return false;
    decode_tile(raw, tile);
    return true;
  };
}

std::unique_ptr<HeightSource> make_height_rows(const SegmentReader& heights,
                                               const Manifest& manifest) {
  return std::make_unique<HeightRows>(heights, manifest);
}

}  // namespace arete::store
