#include "arete/raster/reproject.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <list>
#include <unordered_map>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "arete/core/error.h"
#include "arete/raster/grid_map.h"
#include "arete/raster/placement.h"

namespace arete::raster {
namespace {

constexpr int kMostStripRows = 64;
constexpr int kTileCols = 256;
constexpr double kTolerancePosts = 0.01;
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

std::size_t row_bytes(int cols) {
  return static_cast<std::size_t>(cols) * sizeof(float);
}

int strip_rows(int cols, std::size_t bytes) {
  return static_cast<int>(std::clamp<std::size_t>(bytes / row_bytes(cols), 1, kMostStripRows));
}

// The source's rows that were used last, oldest dropped first.
class RowCache {
 public:
  RowCache(HeightSource& source, std::size_t bytes)
      : source_(source), capacity_(std::max<std::size_t>(2, bytes / row_bytes(source.cols()))) {}

  // Pointers to rows first..last, good until the next call.
  const std::vector<const float*>& fetch(int first, int last) {
    pointers_.clear();
    const auto wanted = static_cast<std::size_t>(last) - static_cast<std::size_t>(first) + 1;
    for (int r = first; r <= last; ++r) pointers_.push_back(touch(r));
    while (order_.size() > std::max(capacity_, wanted)) {
      rows_.erase(order_.back());
      order_.pop_back();
    }
    return pointers_;
  }

 private:
  struct Entry {
    std::vector<float> heights;
    std::list<int>::iterator place;
  };

  const float* touch(int r) {
    if (const auto found = rows_.find(r); found != rows_.end()) {
      order_.splice(order_.begin(), order_, found->second.place);
      return found->second.heights.data();
    }
    std::vector<float> heights(static_cast<std::size_t>(source_.cols()));
    source_.read_row(r, heights);
    order_.push_front(r);
    Entry& entry = rows_[r];
    entry = {std::move(heights), order_.begin()};
    return entry.heights.data();
  }

  HeightSource& source_;
  std::size_t capacity_;
  std::unordered_map<int, Entry> rows_;
  std::list<int> order_;  ///< latest first
  std::vector<const float*> pointers_;
};

struct Grid {
  int cols = 0, rows = 0;
  Affine2 crs_from_post;
};

struct Box {
  glm::dvec2 low{std::numeric_limits<double>::infinity()};
  glm::dvec2 high{-std::numeric_limits<double>::infinity()};
};

// The source's extent in the new CRS, from 65 x 65 posts spread over it.
Box extent(const GridMap& map, int cols, int rows) {
  constexpr int kSteps = 64;
  Box box;
  std::vector<double> x(kSteps + 1), y(kSteps + 1);
  for (int i = 0; i <= kSteps; ++i) {
    map.map_row(0, (cols - 1) / double{kSteps}, (rows - 1) * i / double{kSteps}, x, y);
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (std::isnan(x[k])) continue;
      box.low = glm::min(box.low, {x[k], y[k]});
      box.high = glm::max(box.high, {x[k], y[k]});
    }
  }
  return box;
}

// As many posts along the diagonal as the source has (GDAL's rule for a warp's resolution).
Grid cover(const Box& box, int cols, int rows) {
  const glm::dvec2 size = box.high - box.low;
  const double spacing = glm::length(size) / std::max(1.0, std::hypot(cols - 1, rows - 1));
  if (!std::isfinite(spacing) || spacing <= 0) return {};
  Grid grid;
  // A last post within a hundredth of the far edge is on it.
  const double most = 1 << 30;
  grid.cols = static_cast<int>(std::min(most, std::floor(size.x / spacing + 0.01))) + 1;
  grid.rows = static_cast<int>(std::min(most, std::floor(size.y / spacing + 0.01))) + 1;
  grid.crs_from_post = Affine2{{spacing, 0, box.low.x, 0, -spacing, box.high.y}};
  return grid;
}

// Bilinear between the valid ones of the four posts, if the nearest is valid.
float sample(const std::vector<const float*>& rows, int first_row, glm::dvec2 at, glm::ivec2 last) {
  const auto corner = glm::max(glm::min(glm::ivec2(glm::floor(at)), last - 1), 0);
  const glm::dvec2 f = glm::clamp(at - glm::dvec2(corner), 0.0, 1.0);
  const glm::ivec2 far = glm::min(corner + 1, last);
  const auto height = [&](int c, int r) {
    return rows[static_cast<std::size_t>(r - first_row)][c];
  };
  if (std::isnan(height(f.x < 0.5 ? corner.x : far.x, f.y < 0.5 ? corner.y : far.y))) return kNone;
  double sum = 0, weights = 0;
  const auto add = [&](float z, double weight) {
    if (std::isnan(z)) return;
    sum += weight * static_cast<double>(z);
    weights += weight;
  };
  add(height(corner.x, corner.y), (1 - f.x) * (1 - f.y));
  add(height(far.x, corner.y), f.x * (1 - f.y));
  add(height(corner.x, far.y), (1 - f.x) * f.y);
  add(height(far.x, far.y), f.x * f.y);
  return static_cast<float>(sum / weights);
}

class Reprojected final : public HeightSource {
 public:
  Reprojected(std::unique_ptr<HeightSource> source, const Grid& grid, Georef georef,
              const std::string& name, std::size_t memory_limit)
      : source_(std::move(source)),
        grid_(grid),
        georef_(std::move(georef)),
        map_({grid.crs_from_post, georef_.crs},
             {source_->georef().crs_from_post, source_->georef().crs}, name, kTolerancePosts),
        cache_(*source_, memory_limit / 8),
        strip_rows_(strip_rows(grid.cols, memory_limit / 16)),
        strip_(static_cast<std::size_t>(grid.cols) * static_cast<std::size_t>(strip_rows_)) {}

  int cols() const override { return grid_.cols; }
  int rows() const override { return grid_.rows; }

  Georef georef() const override {
    Georef georef = georef_;
    const Georef from = source_->georef();
    georef.notes = from.notes;
    georef.notes.push_back(fmt::format(
        "Reprojected from {} to {}: {} x {} posts became {} x {}, bilinear.", from.crs_name,
        georef.crs_name, source_->cols(), source_->rows(), grid_.cols, grid_.rows));
    return georef;
  }

  std::string description() const override { return source_->description(); }

  void read_row(int r, std::span<float> row) override {
    if (r < strip_first_ || r >= strip_first_ + strip_rows_) {
      fill_strip(r / strip_rows_ * strip_rows_);
    }
    const auto start = strip_.begin() + std::ptrdiff_t{r - strip_first_} * grid_.cols;
    std::copy(start, start + grid_.cols, row.begin());
  }

 private:
  void fill_strip(int first) {
    strip_first_ = -strip_rows_;
    std::fill(strip_.begin(), strip_.end(), kNone);
    const int count = std::min(strip_rows_, grid_.rows - first);
    for (int col = 0; col < grid_.cols; col += kTileCols) {
      fill_tile(first, count, col, std::min(kTileCols, grid_.cols - col));
    }
    strip_first_ = first;
  }

  // Small tiles, so that the rows of the source that one needs are few even for a turned grid.
  void fill_tile(int first_row, int rows, int first_col, int cols) {
    const auto width = static_cast<std::size_t>(cols);
    x_.resize(width * static_cast<std::size_t>(rows));
    y_.resize(x_.size());
    for (int r = 0; r < rows; ++r) {
      const std::size_t at = width * static_cast<std::size_t>(r);
      map_.map_row(first_col, 1, first_row + r, {&x_[at], width}, {&y_[at], width});
    }
    const auto [low, high] = needed_rows();
    if (low > high) return;
    const auto& source_rows = cache_.fetch(low, high);
    const glm::ivec2 last(source_->cols() - 1, source_->rows() - 1);
    for (std::size_t i = 0; i < x_.size(); ++i) {
      if (!inside({x_[i], y_[i]})) continue;
      const std::size_t row = i / width;
      strip_[row * static_cast<std::size_t>(grid_.cols) + static_cast<std::size_t>(first_col) +
             i % width] = sample(source_rows, low, {x_[i], y_[i]}, last);
    }
  }

  // The hull of the posts, and as much around it as the map may be off.
  bool inside(glm::dvec2 p) const {
    constexpr double kSlack = 2 * kTolerancePosts;
    return p.x >= -kSlack && p.y >= -kSlack && p.x <= source_->cols() - 1 + kSlack &&
           p.y <= source_->rows() - 1 + kSlack;
  }

  std::pair<int, int> needed_rows() const {
    int low = source_->rows(), high = -1;
    for (std::size_t i = 0; i < x_.size(); ++i) {
      if (!inside({x_[i], y_[i]})) continue;
      const int row = std::max(0, static_cast<int>(std::floor(y_[i])));
      low = std::min(low, row);
      high = std::max(high, row + 1);
    }
    // One more row up: the cell of the last row begins there.
    return {std::max(0, low - 1), std::min(high, source_->rows() - 1)};
  }

  std::unique_ptr<HeightSource> source_;
  Grid grid_;
  Georef georef_;
  GridMap map_;
  RowCache cache_;
  int strip_rows_;
  std::vector<float> strip_;
  int strip_first_ = -strip_rows_;
  std::vector<double> x_, y_;
};

}  // namespace

std::unique_ptr<HeightSource> reproject(std::unique_ptr<HeightSource> source,
                                        const std::string& name, const DemOptions& options) {
  const Georef from = source->georef();
  const OGRSpatialReference target = parse_crs(options.crs, name);
  if (from.crs.empty()) {
    throw Error(ErrorCode::InvalidInput,
                fmt::format("{}: names no CRS to reproject from: name --source-crs", name));
  }
  if (parse_crs(from.crs, name).IsSame(&target) != 0) return source;
  Georef georef;
  fill_world(georef, 1, 1, &target);
  const GridMap outward({from.crs_from_post, from.crs}, {Affine2{{1, 0, 0, 0, 1, 0}}, georef.crs},
                        name, 0);
  const Grid grid =
      cover(extent(outward, source->cols(), source->rows()), source->cols(), source->rows());
  if (grid.cols < 1) {
    throw Error(ErrorCode::InvalidInput,
                fmt::format("{}: lies outside of {}: name another --crs", name, options.crs));
  }
  if (grid.cols > options.max_side || grid.rows > options.max_side) {
    throw Error(ErrorCode::Limit,
                fmt::format("{}: {} x {} posts in {}, over {} a side: reproject it in parts", name,
                            grid.cols, grid.rows, options.crs, options.max_side));
  }
  georef.crs_from_post = grid.crs_from_post;
  fill_world(georef, grid.cols, grid.rows, &target);
  return std::make_unique<Reprojected>(std::move(source), grid, std::move(georef), name,
                                       options.memory_limit);
}

}  // namespace arete::raster
