#include "arete/mesh/coverage.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <optional>
#include <vector>

#include "arete/core/parallel.h"
#include "arete/mesh/post_projection.h"

namespace arete::mesh {
namespace {

std::int64_t floor_div(std::int64_t a, std::int64_t b) {
  return a / b - static_cast<std::int64_t>((a % b != 0) && ((a < 0) != (b < 0)));
}

// Going east along the centre line of `row`, the winding number changes by `delta`: for whole
// cells from `cell` on. For the cell that the boundary cuts, if any, see Cut.
struct Crossing {
  std::int32_t row, cell;
  int delta;
};

// The boundary runs through the inside of a cell, on the chord x = x_centre + slope (y - 1/2) of
// the unit square (y runs south). East of it the winding number is `delta` higher.
struct Cut {
  std::int32_t row, cell;
  int delta;
  bool counted;  // the cell's own winding number has the change already
  double x_centre, slope;

  bool east(glm::dvec2 p) const { return p.x > x_centre + slope * (p.y - 0.5); }
  glm::dvec2 midpoint() const;
};

struct RowEvents {
  std::vector<Crossing> crossings;
  std::vector<Cut> cuts;
};

glm::dvec2 Cut::midpoint() const {
  // y where the chord meets x = 0 and x = 1; a chord is never vertical.
  const double y0 = 0.5 - x_centre / slope;
  const double y1 = y0 + 1 / slope;
  const double y = (std::max(0.0, std::min(y0, y1)) + std::min(1.0, std::max(y0, y1))) / 2;
  return {x_centre + slope * (y - 0.5), y};
}

// Adds the events of one piece, top end first, in one row of cells.
void add_row(const BoundaryPiece& p, std::int32_t row, int delta, RowEvents& out) {
  const std::int64_t dr = std::int64_t{p.b.row} - p.a.row;
  const std::int64_t dc = std::int64_t{p.b.col} - p.a.col;
  const std::int64_t down = std::int64_t{row} - p.a.row;
  // Columns are exact in units of 1 / (2 dr).
  const std::int64_t x_top = 2 * (std::int64_t{p.a.col} * dr + dc * down);
  const std::int64_t x_mid = x_top + dc;
  const std::int64_t x_bottom = x_mid + dc;
  const auto first_whole = static_cast<std::int32_t>(-floor_div(-x_mid, 2 * dr));
  out.crossings.push_back({row, first_whole, delta});
  if (dc == 0) return;
  const std::int64_t c0 = floor_div(std::min(x_top, x_bottom), 2 * dr);
  const std::int64_t c1 = -floor_div(-std::max(x_top, x_bottom), 2 * dr);
  const double slope = static_cast<double>(dc) / static_cast<double>(dr);
  for (std::int64_t c = c0; c < c1; ++c) {
    const double x_centre = static_cast<double>(x_mid - 2 * c * dr) / static_cast<double>(2 * dr);
    out.cuts.push_back(
        {row, static_cast<std::int32_t>(c), delta, first_whole <= c, x_centre, slope});
  }
}

RowEvents collect_events(std::span<const BoundaryPiece> boundary) {
  RowEvents out;
  for (BoundaryPiece p : boundary) {
    if (p.a.row == p.b.row) continue;
    // A piece that runs south has the surface on its east side.
    const int delta = p.b.row > p.a.row ? p.net : -p.net;
    if (p.b.row < p.a.row) std::swap(p.a, p.b);
    for (std::int32_t r = p.a.row; r < p.b.row; ++r) add_row(p, r, delta, out);
  }
  const auto by_place = [](const auto& a, const auto& b) {
    return a.row != b.row ? a.row < b.row : a.cell < b.cell;
  };
  std::ranges::sort(out.crossings, by_place);
  std::ranges::sort(out.cuts, by_place);
  return out;
}

// Which cells must be covered.
class Required {
 public:
  Required(const Heightfield& dem, const View* view) : dem_(dem) {
    if (view != nullptr) projection_.emplace(*view, dem.georef().world_from_post);
  }

  bool operator()(Post cell) const {
    return dem_.drawable(cell) &&
           (!projection_ || (seen(cell) && seen({cell.col + 1, cell.row}) &&
                             seen({cell.col, cell.row + 1}) && seen({cell.col + 1, cell.row + 1})));
  }

  // Required cells among [c0, c1) of a row of cells.
  std::uint64_t count(std::int32_t row, std::int32_t c0, std::int32_t c1) const {
    std::uint64_t n = 0;
    for (std::int32_t c = c0; c < c1; c += kChunk) {
      const std::int32_t end = std::min(c + kChunk, c1);
      if (projection_ && outside(row, c, end)) continue;
      for (std::int32_t i = c; i < end; ++i) n += static_cast<std::uint64_t>((*this)({i, row}));
    }
    return n;
  }

 private:
  static constexpr std::int32_t kChunk = 64;

  bool seen(Post p) const {
    return projection_->inside(projection_->clip(p.col, p.row, double{dem_[p]}));
  }

  // True when no post of row `row`, columns [c0, c1), can be seen.
  bool outside(std::int32_t row, std::int32_t c0, std::int32_t c1) const {
    float lo = std::numeric_limits<float>::infinity();
    float hi = -lo;
    for (const float z :
         dem_.row(row).subspan(static_cast<std::size_t>(c0), static_cast<std::size_t>(c1 - c0))) {
      lo = z < lo ? z : lo;  // false for NaN
      hi = z > hi ? z : hi;
    }
    if (lo > hi) return true;
    const PostProjection& p = *projection_;
    const std::array<glm::dvec3, 4> corners{
        p.clip(c0, row, double{lo}), p.clip(c0, row, double{hi}), p.clip(c1 - 1, row, double{lo}),
        p.clip(c1 - 1, row, double{hi})};
    const auto all = [&](auto test) { return std::ranges::all_of(corners, test); };
    return all([&](glm::dvec3 c) { return c.z < p.near_m; }) ||
           all([](glm::dvec3 c) { return c.x < -c.z; }) ||
           all([](glm::dvec3 c) { return c.x > c.z; }) ||
           all([](glm::dvec3 c) { return c.y < -c.z; }) ||
           all([](glm::dvec3 c) { return c.y > c.z; });
  }

  const Heightfield& dem_;
  std::optional<PostProjection> projection_;
};

// Walks one row of cells from west to east.
class RowScan {
 public:
  RowScan(const Heightfield& dem, const Required& required, std::int32_t row)
      : required_(required),
        row_(row),
        cells_(dem.cols() - 1),
        in_grid_(row >= 0 && row + 1 < dem.rows()) {}

  CoverageReport scan(std::span<const Crossing> crossings, std::span<const Cut> cuts) {
    std::int32_t from = std::numeric_limits<std::int32_t>::min();
    int winding = 0;
    for (const Crossing& x : crossings) {
      add_run(from, x.cell, winding, cuts);
      winding += x.delta;
      from = std::max(from, x.cell);
    }
    add_run(from, std::numeric_limits<std::int32_t>::max(), winding, cuts);
    return report_;
  }

 private:
  // Cells [c0, c1) have the same winding, but for those that the boundary cuts.
  void add_run(std::int32_t c0, std::int32_t c1, int winding, std::span<const Cut>& cuts) {
    while (!cuts.empty() && cuts.front().cell < c1 && c0 < c1) {
      const std::int32_t cell = cuts.front().cell;
      add_whole(c0, cell, winding);
      std::size_t n = 0;
      while (n < cuts.size() && cuts[n].cell == cell) ++n;
      add_cut(cell, winding, cuts.first(n));
      cuts = cuts.subspan(n);
      c0 = cell + 1;
    }
    add_whole(c0, c1, winding);
  }

  void add_whole(std::int32_t c0, std::int32_t c1, int winding) {
    if (c0 >= c1 || winding == 1) return;
    if (winding > 1) {
      report_.overlapped_cells += static_cast<std::uint64_t>(std::int64_t{c1} - c0);
    } else if (in_grid_) {
      const std::int32_t first = std::max(c0, 0);
      const std::int32_t last = std::min(c1, cells_);
      if (first < last) report_.uncovered_cells += required_.count(row_, first, last);
    }
  }

  // A cut cell is never covered just once all over: it is overlapped or partly uncovered.
  void add_cut(std::int32_t cell, int winding, std::span<const Cut> cuts) {
    if (highest_winding(winding, cuts) > 1) {
      ++report_.overlapped_cells;
    } else if (in_grid_ && cell >= 0 && cell < cells_ && required_({cell, row_})) {
      ++report_.uncovered_cells;
    }
  }

  // Chords of a valid surface's boundary do not cross, so every part of the cell has a chord's
  // midpoint on its border.
  static int highest_winding(int winding, std::span<const Cut> cuts) {
    int highest = std::numeric_limits<int>::min();
    for (const Cut& chord : cuts) {
      const glm::dvec2 p = chord.midpoint();
      int west = winding;
      for (const Cut& k : cuts) {
        const bool east = &k != &chord && k.east(p);
        west += k.delta * (static_cast<int>(east) - static_cast<int>(k.counted));
      }
      highest = std::max({highest, west, west + chord.delta});
    }
    return highest;
  }

  const Required& required_;
  std::int32_t row_, cells_;
  bool in_grid_;
  CoverageReport report_;
};

template <typename Event>
std::span<const Event> events_of(const std::vector<Event>& events, std::int32_t row) {
  return {std::ranges::lower_bound(events, row, {}, &Event::row),
          std::ranges::upper_bound(events, row, {}, &Event::row)};
}

}  // namespace

CoverageReport measure_coverage(std::span<const BoundaryPiece> boundary, const Heightfield& dem,
                                const View* view, int threads) {
  const RowEvents events = collect_events(boundary);
  const Required required(dem, view);
  std::int32_t first = 0;
  std::int32_t last = dem.rows() - 1;  // one past the last row of cells
  if (!events.crossings.empty()) {
    first = std::min(first, events.crossings.front().row);
    last = std::max(last, events.crossings.back().row + 1);
  }
  constexpr std::int32_t kRowsAtOnce = 32;
  std::atomic<std::uint64_t> uncovered{0};
  std::atomic<std::uint64_t> overlapped{0};
  const auto scan_rows = [&](int chunk) {
    const std::int32_t begin = first + chunk * kRowsAtOnce;
    for (std::int32_t r = begin; r < std::min(begin + kRowsAtOnce, last); ++r) {
      const CoverageReport row =
          RowScan(dem, required, r).scan(events_of(events.crossings, r), events_of(events.cuts, r));
      uncovered += row.uncovered_cells;
      overlapped += row.overlapped_cells;
    }
  };
  parallel_for(threads, (last - first + kRowsAtOnce - 1) / kRowsAtOnce, scan_rows);
  return {uncovered, overlapped};
}

}  // namespace arete::mesh
