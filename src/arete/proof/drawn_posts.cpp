#include "arete/proof/drawn_posts.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arete::proof {
namespace {

constexpr int kSide = Reference::kTilePosts;

// Drawn corner: column, row, metres.
glm::dvec3 corner(const mesh::SurfaceVertex& v) {
  return {double{v.dcol} + v.post.col, double{v.drow} + v.post.row, double{v.z}};
}

// One triangle over the posts of one tile. Positions are relative to the tile's first post.
class TriangleScan {
 public:
  TriangleScan(const mesh::Surface& s, std::uint32_t triangle, Post origin) {
    for (std::size_t k = 0; k < 3; ++k) {
      p_[k] = corner(s.vertices[s.indices[3 * std::size_t{triangle} + k]]) -
              glm::dvec3(origin.col, origin.row, 0);
    }
    const glm::dvec3 u = p_[1] - p_[0];
    const glm::dvec3 v = p_[2] - p_[0];
    const double area = u.x * v.y - u.y * v.x;
    drawn_ = area != 0;
    per_col_ = (u.z * v.y - v.z * u.y) / area;
    per_row_ = (v.z * u.x - u.z * v.x) / area;
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3 edge = p_[(k + 1) % 3] - p_[k];
      slope_[k] = edge.y == 0 ? 0 : edge.x / edge.y;
    }
  }

  bool drawn() const { return drawn_; }
  int first_row() const { return ceil_within(std::min({p_[0].y, p_[1].y, p_[2].y})); }
  int end_row() const { return floor_within(std::max({p_[0].y, p_[1].y, p_[2].y})) + 1; }

  // Half-open range of columns that the closed triangle has on a row.
  std::array<int, 2> columns(int row) const {
    double lo = std::numeric_limits<double>::infinity();
    double hi = -lo;
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3& a = p_[k];
      const glm::dvec3& b = p_[(k + 1) % 3];
      if (row < std::min(a.y, b.y) - kSlack || row > std::max(a.y, b.y) + kSlack) continue;
      const double x = a.y == b.y ? b.x : a.x + (row - a.y) * slope_[k];
      lo = std::min({lo, x, a.y == b.y ? a.x : x});
      hi = std::max({hi, x, a.y == b.y ? a.x : x});
    }
    return {ceil_within(lo), floor_within(hi) + 1};
  }

  double height(int col, int row) const {
    return p_[0].z + (col - p_[0].x) * per_col_ + (row - p_[0].y) * per_row_;
  }
  double per_col() const { return per_col_; }

 private:
  // Posts this close to an edge belong to it: covers the rounding of moved corners.
  static constexpr double kSlack = 1e-6;

  // Rounding to [0, kSide - 1] without calls into the C library.
  static int ceil_within(double x) {
    return x <= 0 ? 0 : kSide - static_cast<int>(kSide - std::min(x - kSlack, double{kSide}));
  }
  static int floor_within(double x) {
    return x < -kSlack ? -1 : static_cast<int>(std::min(x + kSlack, double{kSide - 1}));
  }

  std::array<glm::dvec3, 3> p_;
  std::array<double, 3> slope_{};
  double per_col_ = 0, per_row_ = 0;
  bool drawn_ = false;
};

struct TileRange {
  int col0, row0, col1, row1;  // inclusive
};

TileRange tiles_under(const mesh::Surface& s, std::size_t triangle, const Reference& reference) {
  glm::dvec3 lo(std::numeric_limits<double>::infinity());
  glm::dvec3 hi = -lo;
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::dvec3 p = corner(s.vertices[s.indices[3 * triangle + k]]);
    lo = glm::min(lo, p);
    hi = glm::max(hi, p);
  }
  const auto tile = [](double x, int tiles) {
    return x > 0 ? static_cast<int>(std::min(x, double{kSide} * tiles)) / kSide : 0;
  };
  const int cols = reference.tile_cols();
  const int rows = reference.tile_rows();
  return {tile(lo.x, cols), tile(lo.y, rows), std::min(tile(hi.x, cols), cols - 1),
          std::min(tile(hi.y, rows), rows - 1)};
}

}  // namespace

DrawnPosts::DrawnPosts(const mesh::Surface& surface, const Reference& reference,
                       std::span<const int> tiles)
    : surface_(surface), reference_(reference) {
  std::vector<char> wanted(static_cast<std::size_t>(reference.tiles()));
  for (const int t : tiles) wanted[static_cast<std::size_t>(t)] = 1;
  const auto visit = [&](auto&& use) {
    for (std::size_t i = 0; i < surface.triangles(); ++i) {
      const TileRange range = tiles_under(surface, i, reference);
      for (int r = range.row0; r <= range.row1; ++r) {
        for (int c = range.col0; c <= range.col1; ++c) {
          const int t = r * reference.tile_cols() + c;
          if (wanted[static_cast<std::size_t>(t)] != 0) {
            use(static_cast<std::size_t>(t), static_cast<std::uint32_t>(i));
          }
        }
      }
    }
  };
  first_.assign(wanted.size() + 1, 0);
  visit([&](std::size_t t, std::uint32_t) { ++first_[t + 1]; });
  for (std::size_t t = 1; t < first_.size(); ++t) first_[t] += first_[t - 1];
  triangles_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  visit([&](std::size_t t, std::uint32_t triangle) { triangles_[next[t]++] = triangle; });
}

std::span<const std::uint32_t> DrawnPosts::triangles_of(int tile) const {
  const auto t = static_cast<std::size_t>(tile);
  return std::span(triangles_).subspan(first_[t], first_[t + 1] - first_[t]);
}

void DrawnPosts::read(int tile, PostHeights& z) const {
  z.fill(std::numeric_limits<double>::quiet_NaN());
  const PostRect rect = reference_.posts_of(tile);
  for (const std::uint32_t triangle : triangles_of(tile)) {
    const TriangleScan scan(surface_, triangle, {rect.col0, rect.row0});
    if (!scan.drawn()) continue;
    const int end_row = std::min(scan.end_row(), rect.row1 - rect.row0);
    for (int r = scan.first_row(); r < end_row; ++r) {
      const std::array<int, 2> cols = scan.columns(r);
      const int end_col = std::min(cols[1], rect.col1 - rect.col0);
      const std::span<const float> truth =
          reference_.dem().row(rect.row0 + r).subspan(static_cast<std::size_t>(rect.col0));
      const double start = scan.height(0, r);
      double* const row = &z[static_cast<std::size_t>(r) * kSide];
      for (int c = cols[0]; c < end_col; ++c) {
        const double drawn = start + c * scan.per_col();
        const double zt = double{truth[static_cast<std::size_t>(c)]};
        double& kept = row[c];
        // Also true when nothing is kept yet (NaN).
        if (!(std::abs(drawn - zt) <= std::abs(kept - zt))) kept = drawn;
      }
    }
  }
}

}  // namespace arete::proof
