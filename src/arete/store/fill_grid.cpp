#include "arete/store/fill_grid.h"

#include <algorithm>
#include <cmath>

namespace arete::store {
namespace {

constexpr std::int64_t kMaxCells = std::int64_t{1} << 22U;
constexpr int kMinCellPosts = 16;
constexpr int kMaxCellPosts = 128;

int cells(int posts, int cell_posts) {
  return (posts + cell_posts - 1) / cell_posts;
}

int choose_cell_posts(int cols, int rows) {
  int n = kMinCellPosts;
  while (n < kMaxCellPosts && std::int64_t{cells(cols, n)} * cells(rows, n) > kMaxCells) n *= 2;
  return n;
}

std::size_t index(int cols, int x, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(cols) + static_cast<std::size_t>(x);
}

// Bilinear value at cell coordinates (centres at integers), clamped at the borders.
double bilinear(const std::vector<double>& grid, int cols, int rows, double x, double y) {
  x = std::clamp(x, 0.0, cols - 1.0);
  y = std::clamp(y, 0.0, rows - 1.0);
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, cols - 1);
  const int y1 = std::min(y0 + 1, rows - 1);
  const double fx = x - x0;
  const double fy = y - y0;
  const double north = grid[index(cols, x0, y0)] * (1 - fx) + grid[index(cols, x1, y0)] * fx;
  const double south = grid[index(cols, x0, y1)] * (1 - fx) + grid[index(cols, x1, y1)] * fx;
  return north * (1 - fy) + south * fy;
}

struct Level {
  int cols = 0, rows = 0;
  std::vector<FillGrid::Cell> cells;
};

Level push(const Level& fine) {
  Level coarse{cells(fine.cols, 2), cells(fine.rows, 2), {}};
  coarse.cells.resize(index(coarse.cols, 0, coarse.rows));
  for (int y = 0; y < fine.rows; ++y)
    for (int x = 0; x < fine.cols; ++x) {
      const FillGrid::Cell& from = fine.cells[index(fine.cols, x, y)];
      FillGrid::Cell& to = coarse.cells[index(coarse.cols, x / 2, y / 2)];
      to.sum += from.sum;
      to.count += from.count;
    }
  return coarse;
}

// Own average where there is data, else the coarser level's value there.
std::vector<double> pull(const Level& fine, const Level* coarse, const std::vector<double>& above) {
  std::vector<double> values(fine.cells.size());
  for (int y = 0; y < fine.rows; ++y)
    for (int x = 0; x < fine.cols; ++x) {
      const std::size_t i = index(fine.cols, x, y);
      const FillGrid::Cell& cell = fine.cells[i];
      if (cell.count > 0)
        values[i] = static_cast<double>(cell.sum) / static_cast<double>(cell.count);
      else if (coarse != nullptr)
        values[i] = bilinear(above, coarse->cols, coarse->rows, (x - 0.5) / 2, (y - 0.5) / 2);
    }
  return values;
}

}  // namespace

FillGrid::FillGrid(int cols, int rows)
    : cols_(0), rows_(0), cell_posts_(choose_cell_posts(cols, rows)) {
  cols_ = cells(cols, cell_posts_);
  rows_ = cells(rows, cell_posts_);
  cells_.resize(index(cols_, 0, rows_));
}

void FillGrid::set_rows(int first_row, std::span<const Cell> cells) {
  std::ranges::copy(cells,
                    cells_.begin() + static_cast<std::ptrdiff_t>(index(cols_, 0, first_row)));
}

void FillGrid::finish() {
  std::vector<Level> levels;
  levels.push_back({cols_, rows_, std::move(cells_)});
  while (levels.back().cols > 1 || levels.back().rows > 1) levels.push_back(push(levels.back()));
  filled_ = pull(levels.back(), nullptr, {});
  for (std::size_t i = levels.size() - 1; i-- > 0;)
    filled_ = pull(levels[i], &levels[i + 1], filled_);
}

std::int32_t FillGrid::at(Post post) const {
  const double x = (post.col + 0.5) / cell_posts_ - 0.5;
  const double y = (post.row + 0.5) / cell_posts_ - 0.5;
  return static_cast<std::int32_t>(std::lrint(bilinear(filled_, cols_, rows_, x, y)));
}

}  // namespace arete::store
