#include "arete/lod/bintree/own_delta.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace arete::lod::bintree {
namespace {

// More than 0 and less than any distance of lattice heights from a plane: a slope that the posts
// lie on exactly still is drawn through rounded heights.
constexpr double kTrace = 0x1p-60;

// Two at a time, and two of those: the compilers make vector code of it.
using Pair = double __attribute__((vector_size(16)));

Pair pair_at(const double* z) {
  Pair pair;
  std::memcpy(&pair, z, sizeof pair);
  return pair;
}

// Range of z - plane over posts met so far; NaN do not count: no comparison holds for them.
struct Range {
  Pair over{}, under{};
  void add(Pair gap) {
    over = over < gap ? gap : over;
    under = gap < under ? gap : under;
  }
  double greatest() const { return std::max({over[0], over[1], -under[0], -under[1]}); }
};

// Greatest |z[i] - (base + i step)|, i in [0, n).
double greatest_gap(const double* z, int n, double base, double step) {
  double greatest = 0;
  int i = 0;
  if (n >= 4) {
    Pair first{base, base + step};
    Pair second{base + 2 * step, base + 3 * step};
    const Pair stride{4 * step, 4 * step};
    Range even;
    Range odd;
    for (; i + 4 <= n; i += 4, first += stride, second += stride) {
      even.add(pair_at(z + i) - first);
      odd.add(pair_at(z + i + 2) - second);
    }
    greatest = std::max(even.greatest(), odd.greatest());
  }
  for (; i < n; ++i) {
    const double gap = std::abs(z[i] - (base + i * step));
    greatest = greatest < gap ? gap : greatest;
  }
  return greatest;
}

// A height that is linear along a row: base at the square's western side, step a column.
struct Line {
  double base = 0, step = 0;
};

// The squares of one size, row of posts by row of posts. Corners a c / d b of a square: NW NE /
// SW SE, m its middle. Each run of posts lies in one triangle; legs of a triangle are left to the
// vertices that halve them, which are DAG children.
class SquareRow {
 public:
  SquareRow(const RecordGrid& grid, const PostRows& posts, int level, OwnDeltas& own)
      : grid_(grid),
        posts_(posts),
        half_(1 << level),
        log2_size_(level + 1 + grid.log2_spacing()),
        size_(1 << log2_size_),
        per_size_(1.0 / size_),
        own_(own) {}

  void raise(int row) {
    row_ = row;
    y_ = row & (size_ - 1);
    share_ = y_ * per_size_;
    const PostRect& rect = posts_.rect();
    for (int x = rect.col0 >> log2_size_; x <= (rect.col1 - 1) >> log2_size_; ++x) {
      col_ = x << log2_size_;
      nw_ = {2 * half_ * x, 2 * half_ * (row >> log2_size_)};
      if (y_ == 0)
        raise_northern_side();
      else if (nw_.col == grid_.lattice_cells())
        raise_eastern_border();
      else if (take_corners())
        raise_inside();
    }
  }

 private:
  double count(int col, int row) const { return grid_.count({nw_.col + col, nw_.row + row}); }
  bool holds(int col, int row) const { return grid_.holds({nw_.col + col, nw_.row + row}); }
  double& own(int col, int row) { return own_[grid_.index({nw_.col + col, nw_.row + row})]; }

  void raise_northern_side() {
    if (nw_.col == grid_.lattice_cells() || !holds(0, 0) || !holds(2 * half_, 0)) return;
    a_ = count(0, 0);
    c_ = count(2 * half_, 0);
    raise_run(1, size_ - 1, {a_, scaled(c_ - a_)}, a_ != c_, own(half_, 0));
  }

  void raise_eastern_border() {
    if (!holds(0, 0) || !holds(0, 2 * half_)) return;
    a_ = count(0, 0);
    d_ = count(0, 2 * half_);
    raise_run(0, 0, {a_ + (d_ - a_) * share_, 0}, a_ != d_, own(0, half_));
  }

  bool take_corners() {
    if (!holds(0, 0) || !holds(2 * half_, 2 * half_)) return false;
    a_ = count(0, 0);
    b_ = count(2 * half_, 2 * half_);
    c_ = count(2 * half_, 0);
    d_ = count(0, 2 * half_);
    m_ = count(half_, half_);
    return true;
  }

  void raise_inside() {
    raise_white();
    raise_black();
  }

  // Two triangles on the diagonal that the middle halves: NW - SE where the parities of the square
  // agree, else NE - SW (METHODS 1.2).
  void raise_white() {
    double& white = own(half_, half_);
    const bool slopes = a_ != b_ || a_ != c_ || a_ != d_;
    const Line north{a_, scaled(c_ - a_)};
    const Line south{d_, scaled(b_ - d_)};
    if (((nw_.col + nw_.row) / (2 * half_)) % 2 == 0) {
      raise_run(1, y_, {a_ + (d_ - a_) * share_, south.step}, slopes, white);
      raise_run(y_ + 1, size_ - 1, {a_ + (b_ - c_) * share_, north.step}, slopes, white);
    } else {
      raise_run(1, size_ - y_, {a_ + (d_ - a_) * share_, north.step}, slopes, white);
      raise_run(size_ - y_ + 1, size_ - 1, {d_ + (c_ - b_) * (1 - share_), south.step}, slopes,
                white);
    }
  }

  // Four triangles between the sides and the middle; the eastern side belongs to the next square.
  void raise_black() {
    const int reach = std::min(y_, size_ - y_);
    const double west = a_ + (d_ - a_) * share_;
    const double west_rise = 2 * m_ - a_ - d_;
    raise_run(0, reach, {west, scaled(west_rise)}, a_ != d_ || west_rise != 0, own(0, half_));
    const double east = c_ + (b_ - c_) * share_;
    const double east_rise = 2 * m_ - b_ - c_;
    raise_run(size_ - reach, size_ - 1, {east + east_rise, -scaled(east_rise)},
              b_ != c_ || east_rise != 0, own(2 * half_, half_));
    if (y_ < size_ / 2) {
      const double rise = 2 * m_ - a_ - c_;
      raise_run(y_ + 1, size_ - y_ - 1, {a_ + share_ * rise, scaled(c_ - a_)},
                a_ != c_ || rise != 0, own(half_, 0));
    } else if (y_ > size_ / 2) {
      const double rise = 2 * m_ - b_ - d_;
      raise_run(reach + 1, size_ - reach - 1, {d_ + (1 - share_) * rise, scaled(b_ - d_)},
                b_ != d_ || rise != 0, own(half_, 2 * half_));
    }
  }

  double scaled(double counts) const { return counts * per_size_; }

  // Posts first .. last of the square's row, as far as they are here.
  void raise_run(int first, int last, const Line& line, bool slopes, double& own) {
    first = std::max(first, posts_.rect().col0 - col_);
    last = std::min(last, posts_.rect().col1 - 1 - col_);
    if (first > last) return;
    const double* z = posts_.row(row_) + (col_ + first - posts_.rect().col0);
    const double gap = greatest_gap(z, last - first + 1, line.base + first * line.step, line.step);
    own = std::max({own, gap, slopes ? kTrace : 0});
  }

  const RecordGrid& grid_;
  const PostRows& posts_;
  int half_, log2_size_, size_;  // half in lattice posts, size in level-0 posts
  double per_size_;
  OwnDeltas& own_;
  int row_ = 0, y_ = 0, col_ = 0;
  double share_ = 0;
  Post nw_;
  double a_ = 0, b_ = 0, c_ = 0, d_ = 0, m_ = 0;
};

// Squares of two cells hold one post that is no corner, and each of their sides another: no runs.
class FinestRow {
 public:
  FinestRow(const RecordGrid& grid, const PostRows& posts, OwnDeltas& own)
      : grid_(grid), posts_(posts), own_(own) {}

  void raise(int row) {
    const PostRect& rect = posts_.rect();
    const PostRect& region = grid_.region();
    row_ = row;
    const bool odd_row = row % 2 != 0;
    const int first = std::max(rect.col0, region.col0 + 1);
    const int end = std::min(rect.col1, region.col1 - 1);
    if (!odd_row) {
      for (int c = first | 1; c < end; c += 2) raise(c, {-1, 0});
      return;
    }
    if (row == region.row0 || row + 1 == region.row1) return;
    for (int c = rect.col0 + (rect.col0 & 1); c < rect.col1; c += 2) raise(c, {0, -1});
    // The diagonal that the middle halves (METHODS 1.2).
    for (int c = first | 1; c < end; c += 2) raise(c, {(c / 2 + row / 2) % 2 == 0 ? -1 : 1, -1});
  }

 private:
  // Half of the base edge leads from the post to one of its ends.
  void raise(int col, Post half) {
    const double a = grid_.count({col + half.col, row_ + half.row});
    const double b = grid_.count({col - half.col, row_ - half.row});
    const double gap = std::abs(posts_.row(row_)[col - posts_.rect().col0] - (a + b) / 2);
    const double least = a != b ? kTrace : 0;
    own_[grid_.index({col, row_})] = least < gap ? gap : least;
  }

  const RecordGrid& grid_;
  const PostRows& posts_;
  OwnDeltas& own_;
  int row_ = 0;
};

}  // namespace

void raise_exact(const RecordGrid& grid, const PostRows& posts, OwnDeltas& own) {
  const bool finest = grid.log2_spacing() == 0;
  if (finest) {
    FinestRow squares(grid, posts, own);
    for (int row = posts.rect().row0; row < posts.rect().row1; ++row) squares.raise(row);
  }
  for (int level = finest ? 1 : 0; level < grid.levels(); ++level) {
    SquareRow squares(grid, posts, level, own);
    for (int row = posts.rect().row0; row < posts.rect().row1; ++row) squares.raise(row);
  }
}

void raise_incremental(const RecordGrid& grid, OwnDeltas& own) {
  const PostRect& region = grid.region();
  const auto raise = [&](Post v, Post left, Post right) {
    if (!grid.holds(left) || !grid.holds(right)) return;
    const double l = grid.count(left);
    const double r = grid.count(right);
    double& delta = own[grid.index(v)];
    delta = std::max({delta, std::abs(grid.count(v) - (l + r) / 2), l == r ? 0 : kTrace});
  };
  for (int level = 0; level < grid.levels(); ++level) {
    const int h = 1 << level;
    for (int r = (region.row0 + h - 1) / h * h; r < region.row1; r += h) {
      for (int c = (region.col0 + h - 1) / h * h; c < region.col1; c += h) {
        const bool odd_col = (c / h) % 2 != 0;
        const bool odd_row = (r / h) % 2 != 0;
        if (!odd_col && !odd_row) continue;
        // The middle of a square halves the diagonal that its parities name.
        const bool falls = (c / (2 * h) + r / (2 * h)) % 2 == 0;
        const Post half{odd_col ? h : 0, !odd_row ? 0 : (odd_col && !falls ? -h : h)};
        raise({c, r}, {c - half.col, r - half.row}, {c + half.col, r + half.row});
      }
    }
  }
}

}  // namespace arete::lod::bintree
