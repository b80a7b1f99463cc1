#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <mutex>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "arete/core/error.h"
#include "arete/raster/dem.h"
#include "arete/raster/grid_map.h"
#include "arete/raster/picture.h"

namespace arete::raster {
namespace {

constexpr int kTile = 256;
constexpr int kChannels = 3;
constexpr int kFinestLog2 = 3;
constexpr std::int64_t kMaxTexels = std::int64_t{1} << 30;
// Beyond these a picture is shrunk, whatever memory there is: bytes must not depend on it.
constexpr std::int64_t kMaxPicturePixels = std::int64_t{160} << 20;
constexpr std::int64_t kKeptTexels = std::int64_t{16} << 20;
constexpr std::uint8_t kOutside = 128;  ///< grey where the picture does not reach

int half(int side) {
  return (side + 1) / 2;
}

// The grid's posts refined 2^log2 times.
GridPlace texel_place(const GridPlace& posts, int log2) {
  GridPlace place = posts;
  const double step = std::ldexp(1.0, -log2);
  for (const std::size_t k : {0U, 1U, 3U, 4U}) place.crs_from_post.m[k] *= step;
  return place;
}

// Pixel i of a picture shrunk by 2^log2 is centred on pixel (i + 1/2) 2^log2 - 1/2 of the file.
GridPlace shrunk_place(const GridPlace& pixels, int log2) {
  GridPlace place = pixels;
  const double step = std::ldexp(1.0, log2);
  const glm::dvec2 first = pixels.crs_from_post.apply(step / 2 - 0.5, step / 2 - 0.5);
  auto& m = place.crs_from_post.m;
  for (const std::size_t k : {0U, 1U, 3U, 4U}) m[k] *= step;
  m[2] = first.x;
  m[5] = first.y;
  return place;
}

// Without a CRS on both sides: the picture's edges half a post outside the outermost posts.
GridPlace stretched(const PictureFile& file, int cols, int rows) {
  const double sx = static_cast<double>(cols) / file.width;
  const double sy = static_cast<double>(rows) / file.height;
  return {Affine2{{sx, 0, sx / 2 - 0.5, 0, sy, sy / 2 - 0.5}}, {}};
}

// The most pixels a post step covers, looked at in 9 x 9 places.
double pixels_per_post(const GridMap& map, int cols, int rows) {
  double most = 0;
  std::array<double, 2> x{}, y{}, x_south{}, y_south{};
  for (int i = 0; i < 81; ++i) {
    const std::div_t place = std::div(i, 9);
    const double col = (cols - 1) * (place.rem / 8.0);
    const double row = (rows - 1) * (place.quot / 8.0);
    map.map_row(col, 1, row, x, y);
    map.map_row(col, 1, row + 1, x_south, y_south);
    const double east = std::hypot(x[1] - x[0], y[1] - y[0]);
    const double south = std::hypot(x_south[0] - x[0], y_south[0] - y[0]);
    if (std::isfinite(east)) most = std::max(most, east);
    if (std::isfinite(south)) most = std::max(most, south);
  }
  return most;
}

class Drape final : public RasterSource {
 public:
  Drape(Picture picture, const GridPlace& texels, const GridPlace& pixels, RasterShape shape,
        double period, const std::string& name)
      : picture_(std::move(picture)),
        shape_(shape),
        period_(period),
        map_(texels, pixels, name, 0.05) {}

  RasterShape shape() const override { return shape_; }

  Texels read(TileId id) const override {
    try {
      if (static_cast<int>(id.level) < kept_level()) return make(id);
      std::call_once(kept_once_, [this] { keep_coarse_levels(); });
      return cut(id);
    } catch (const std::exception&) {
      return blank();
    }
  }

 private:
  // A coarse level in memory: what would otherwise be averaged from all below each time.
  struct Level {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
  };

  Texels blank() const {
    Texels tile{kTile, kChannels, {}};
    tile.bytes.assign(std::size_t{kTile} * kTile * kChannels, kOutside);
    return tile;
  }

  glm::ivec2 size_of(int level) const {
    glm::ivec2 size(shape_.width, shape_.height);
    for (int l = 0; l < level; ++l) size = {half(size.x), half(size.y)};
    return size;
  }

  int kept_level() const {
    int level = 0;
    for (glm::ivec2 s = size_of(0); std::int64_t{s.x} * s.y > kKeptTexels; ++level) {
      s = {half(s.x), half(s.y)};
    }
    return level;
  }

  Texels make(TileId id) const { return id.level == 0 ? warp(id) : average(id); }

  // The texels of a level-0 tile, looked up in the picture.
  Texels warp(TileId id) const {
    Texels tile = blank();
    const glm::ivec2 first(static_cast<int>(id.x) * kTile, static_cast<int>(id.y) * kTile);
    const glm::ivec2 count = glm::min(glm::ivec2(kTile), size_of(0) - first);
    if (count.x <= 0 || count.y <= 0) return tile;
    std::vector<double> x(static_cast<std::size_t>(count.x)), y(x.size());
    for (int r = 0; r < count.y; ++r) {
      {
        const std::lock_guard lock(map_mutex_);  // PROJ's objects are for one thread at a time
        map_.map_row(first.x, 1, first.y + r, x, y);
      }
      std::uint8_t* out = &tile.bytes[static_cast<std::size_t>(r) * kTile * kChannels];
      for (std::size_t i = 0; i < x.size(); ++i, out += kChannels) look_up(x[i], y[i], out);
    }
    return tile;
  }

  // Bilinear within the picture's outer edge; round the globe if it goes round.
  void look_up(double x, double y, std::uint8_t* out) const {
    if (period_ > 0) x -= period_ * std::floor((x + 0.5) / period_);
    const bool inside =
        x >= -0.5 && y >= -0.5 && x <= picture_.width - 0.5 && y <= picture_.height - 0.5;
    if (!inside) return;
    const glm::ivec2 last(picture_.width - 1, picture_.height - 1);
    const glm::ivec2 low =
        glm::clamp(glm::ivec2(glm::floor(glm::dvec2(x, y))), glm::ivec2(0), last);
    const glm::ivec2 high = glm::min(low + 1, last);
    const glm::dvec2 f = glm::clamp(glm::dvec2(x, y) - glm::dvec2(low), 0.0, 1.0);
    for (int k = 0; k < kChannels; ++k) {
      const double north = glm::mix(value(low.x, low.y, k), value(high.x, low.y, k), f.x);
      const double south = glm::mix(value(low.x, high.y, k), value(high.x, high.y, k), f.x);
      out[k] = static_cast<std::uint8_t>(std::lround(glm::mix(north, south, f.y)));
    }
  }

  double value(int x, int y, int k) const {
    const std::size_t at = (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width) +
                            static_cast<std::size_t>(x)) *
                               kChannels +
                           static_cast<std::size_t>(k);
    return picture_.rgb[at];
  }

  // 2 x 2 means of the four children, fewer where the level below ends.
  Texels average(TileId id) const {
    Level below{2 * kTile, 2 * kTile, {}};
    const glm::ivec2 first(static_cast<int>(id.x) * 2 * kTile, static_cast<int>(id.y) * 2 * kTile);
    const glm::ivec2 rest = size_of(static_cast<int>(id.level) - 1) - first;
    below.width = std::clamp(rest.x, 0, 2 * kTile);
    below.height = std::clamp(rest.y, 0, 2 * kTile);
    below.rgb.resize(bytes_of(below));
    for (int i = 0; i < 4; ++i) paste(make(id.child(i)), (i % 2) * kTile, (i / 2) * kTile, below);
    Texels tile = blank();
    copy_out(mean(below), 0, 0, tile);
    return tile;
  }

  static std::size_t bytes_of(const Level& level) {
    return static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height) *
           kChannels;
  }

  static std::size_t offset(const Level& level, int x, int y) {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(level.width) +
            static_cast<std::size_t>(x)) *
           kChannels;
  }

  static void paste(const Texels& tile, int x, int y, Level& level) {
    const int width = std::min(kTile, level.width - x);
    for (int r = 0; width > 0 && r < std::min(kTile, level.height - y); ++r) {
      const auto from = tile.bytes.begin() + std::ptrdiff_t{r} * kTile * kChannels;
      std::copy_n(from, width * kChannels, &level.rgb[offset(level, x, y + r)]);
    }
  }

  static void copy_out(const Level& level, int x, int y, Texels& tile) {
    const int width = std::min(kTile, level.width - x);
    for (int r = 0; width > 0 && r < std::min(kTile, level.height - y); ++r) {
      std::copy_n(&level.rgb[offset(level, x, y + r)], width * kChannels,
                  tile.bytes.begin() + std::ptrdiff_t{r} * kTile * kChannels);
    }
  }

  static Level mean(const Level& fine) {
    Level coarse{half(fine.width), half(fine.height), {}};
    coarse.rgb.resize(bytes_of(coarse));
    for (int y = 0; y < coarse.height; ++y) {
      for (int x = 0; x < coarse.width; ++x) {
        const int x1 = std::min(2 * x + 1, fine.width - 1);
        const int y1 = std::min(2 * y + 1, fine.height - 1);
        for (std::size_t k = 0; k < kChannels; ++k) {
          const int sum =
              fine.rgb[offset(fine, 2 * x, 2 * y) + k] + fine.rgb[offset(fine, x1, 2 * y) + k] +
              fine.rgb[offset(fine, 2 * x, y1) + k] + fine.rgb[offset(fine, x1, y1) + k];
          coarse.rgb[offset(coarse, x, y) + k] = static_cast<std::uint8_t>((sum + 2) / 4);
        }
      }
    }
    return coarse;
  }

  void keep_coarse_levels() const {
    const int first = kept_level();
    const glm::ivec2 size = size_of(first);
    Level level{size.x, size.y, {}};
    level.rgb.resize(bytes_of(level));
    for (int y = 0; y * kTile < size.y; ++y) {
      for (int x = 0; x * kTile < size.x; ++x) {
        const TileId id{static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(x),
                        static_cast<std::uint32_t>(y)};
        paste(make(id), x * kTile, y * kTile, level);
      }
    }
    kept_.push_back(std::move(level));
    while (first + static_cast<int>(kept_.size()) < shape_.levels) {
      kept_.push_back(mean(kept_.back()));
    }
  }

  Texels cut(TileId id) const {
    Texels tile = blank();
    const auto at = id.level - static_cast<std::uint32_t>(kept_level());
    if (at >= kept_.size()) return tile;
    const Level& level = kept_[at];
    const std::int64_t x = std::int64_t{id.x} * kTile, y = std::int64_t{id.y} * kTile;
    if (x >= level.width || y >= level.height) return tile;
    copy_out(level, static_cast<int>(x), static_cast<int>(y), tile);
    return tile;
  }

  Picture picture_;
  RasterShape shape_;
  double period_;  ///< pixels round the globe, 0 = it does not go round
  GridMap map_;
  mutable std::mutex map_mutex_;
  mutable std::once_flag kept_once_;
  mutable std::vector<Level> kept_;  ///< from kept_level() up to the coarsest
};

int finest_log2(double density, int cols, int rows) {
  int log2 = 0;
  const auto fits = [&](int l) {
    return (std::int64_t{cols} << l) * (std::int64_t{rows} << l) <= kMaxTexels;
  };
  while (log2 < kFinestLog2 && std::ldexp(1.0, log2) < density * 0.99 && fits(log2 + 1)) ++log2;
  return log2;
}

// So far that a pixel is no finer than half a texel, and the picture fits into memory.
int shrink_log2(const PictureFile& file, double pixels_per_texel) {
  int log2 = 0;
  while (pixels_per_texel > std::ldexp(2.0, log2) ||
         (std::int64_t{file.width} >> log2) * (file.height >> log2) > kMaxPicturePixels) {
    ++log2;
  }
  return log2;
}

RasterShape shape_for(int cols, int rows, int log2) {
  RasterShape shape;
  shape.width = ((cols - 1) << log2) + 1;
  shape.height = ((rows - 1) << log2) + 1;
  shape.tile_size = kTile;
  shape.channels = kChannels;
  shape.texels_per_post_log2 = log2;
  shape.fill = kOutside;
  shape.levels = 1;
  for (int side = std::max(shape.width, shape.height); side > kTile; side = half(side)) {
    ++shape.levels;
  }
  return shape;
}

// The picture, and the texels that are kept with all levels above them.
void require_memory(const PictureFile& file, int shrink, const RasterShape& shape,
                    std::size_t memory_limit) {
  const std::int64_t pixels = (std::int64_t{file.width} >> shrink) * (file.height >> shrink);
  const std::int64_t kept = std::min(kKeptTexels, std::int64_t{shape.width} * shape.height);
  const std::int64_t bytes = kChannels * (pixels + kept * 4 / 3);
  if (bytes <= static_cast<std::int64_t>(memory_limit)) return;
  throw Error(ErrorCode::Limit,
              fmt::format("{}: takes {} MiB of memory, half of --memory-limit at most: raise it to "
                          "{}M, or shrink the picture",
                          file.name, bytes >> 20U, (2 * bytes >> 20U) + 1));
}

// Pixels in 360 degrees if the picture spans them, else 0.
double period_of(const PictureFile& file) {
  if (!file.geographic) return 0;
  const double turn = 360 / std::abs(file.place.crs_from_post.m[0]);
  return std::abs(turn - file.width) <= 1.5 ? turn : 0;
}

}  // namespace

std::unique_ptr<RasterSource> open_drape(const std::filesystem::path& image, int cols, int rows,
                                         const Georef& georef, std::size_t memory_limit) {
  PictureFile file = open_picture(image);
  GridPlace posts{georef.crs_from_post, georef.crs};
  double period = 0;
  if (posts.crs.empty() || file.place.crs.empty()) {
    posts = {Affine2{{1, 0, 0, 0, 1, 0}}, {}};
    file.place = stretched(file, cols, rows);
  } else {
    period = period_of(file);
  }
  const double density = pixels_per_post(GridMap(posts, file.place, file.name, 0), cols, rows);
  const int finer = finest_log2(density, cols, rows);
  const int shrink = shrink_log2(file, density / std::ldexp(1.0, finer));
  const RasterShape shape = shape_for(cols, rows, finer);
  require_memory(file, shrink, shape, memory_limit);
  const GridPlace pixels = shrunk_place(file.place, shrink);
  return std::make_unique<Drape>(read_picture(file, shrink), texel_place(posts, finer), pixels,
                                 shape, std::ldexp(period, -shrink), file.name);
}

}  // namespace arete::raster
