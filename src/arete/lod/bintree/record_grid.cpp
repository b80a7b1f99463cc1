#include "arete/lod/bintree/record_grid.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "arete/lod/bintree/post_rows.h"

namespace arete::lod::bintree {
namespace {

// Stands in for the radius of a vertex that neither is a drawable post nor has one below it: it is
// never drawn, and no parent's sphere has to hold it.
constexpr Code kEmpty = 0xFFFF;
// Over the rounding of the distance, so that nesting holds for distances computed anew.
constexpr double kRoundUp = 1 + 1e-12;

constexpr std::array<Post, 4> kDiagonals{{{-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};
constexpr std::array<Post, 4> kAxes{{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};

// What the children of a vertex ask of it.
class Parent {
 public:
  Parent(Record& record, double quantum_m) : record_(record), quantum_m_(quantum_m) {}

  void add(const Record& child, double plan_squared) {
    if (child.radius == kEmpty) return;
    const double dz = quantum_m_ * (static_cast<double>(child.count) - record_.count);
    const double distance = std::sqrt(plan_squared + dz * dz) * kRoundUp;
    radius_ = std::max(radius_, distance + static_cast<double>(value(child.radius)));
    record_.delta = std::max(record_.delta, child.delta);
  }
  Code close() {
    if (radius_ > 0)
      record_.radius = code_up(radius_);
    else
      record_.delta = 0;
    return record_.delta;
  }

 private:
  Record& record_;
  double quantum_m_;
  double radius_ = 0;
};

// First multiple of `step` plus `offset` at or after `from`.
int first_at(int from, int step, int offset) {
  return from + ((offset - from) % step + step) % step;
}

}  // namespace

// A way to a child, and the square of its length in the plane.
struct RecordGrid::Step {
  Post direction;
  double squared_m = 0;
};

RecordGrid::RecordGrid(const store::Terrain& terrain, const Groups& groups, const BlockId& block)
    : block_(block),
      region_(groups.region(block)),
      log2_spacing_(groups.log2_spacing(block.group)),
      levels_(groups.levels(block.group)),
      cells_(groups.lattice_cells(block.group)),
      width_(static_cast<std::size_t>(region_.col1 - region_.col0)),
      quantum_m_(terrain.manifest().quantum_m),
      world_from_post_(terrain.manifest().georef.world_from_post) {
  std::vector<std::int32_t> counts;
  load_lattice(terrain, log2_spacing_, region_, counts);
  records_.resize(counts.size());
  std::ranges::transform(counts, records_.begin(), [](std::int32_t count) {
    return Record{count, 0, kEmpty};
  });
  if (block.group > 0) finer_.assign(records_.size(), Record{0, 0, kEmpty});
}

// White vertices of other than the finest level have a radius if they have a drawable post.
void RecordGrid::set_finer(Post cell, const Record& record) {
  if (!holds(cell)) return;
  Record& kept = finer_[index(cell)];
  kept = record;
  if (record.radius == 0) kept.radius = kEmpty;
}

std::array<RecordGrid::Step, 4> RecordGrid::steps(std::span<const Post> offsets,
                                                  double unit) const {
  std::array<Step, 4> steps;
  const auto& m = world_from_post_.m;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double col = unit * offsets[i].col;
    const double row = unit * offsets[i].row;
    steps[i] = {offsets[i],
                std::pow(m[0] * col + m[1] * row, 2) + std::pow(m[3] * col + m[4] * row, 2)};
  }
  return steps;
}

void RecordGrid::nest(std::span<const double> own, double slack_m) {
  assert(own.size() == records_.size());
  for (std::size_t i = 0; i < records_.size(); ++i)
    if (own[i] > 0) records_[i].delta = code_up(own[i] * quantum_m_ + slack_m);
  for (int level = 0; level < levels_; ++level) {
    maxima_.push_back(nest_black(1 << level));
    maxima_.push_back(nest_white(1 << level));
  }
  finish();
}

// Midpoints of the sides of squares of 2 half: one coordinate is an odd multiple of half. Their
// children are the middles of the squares of one half that touch them.
Code RecordGrid::nest_black(int half) {
  Code greatest = 0;
  const auto children = steps(kDiagonals, std::ldexp(half, log2_spacing_ - 1));
  for (int r = first_at(region_.row0, half, 0); r < region_.row1; r += half) {
    const int odd = r / half % 2 == 0 ? half : 0;
    for (int c = first_at(region_.col0, 2 * half, odd); c < region_.col1; c += 2 * half) {
      Record& record = records_[index({c, r})];
      if (half == 1 && finer_.empty()) {
        if (record.radius == kEmpty) record.delta = 0;
        greatest = std::max(greatest, record.delta);
        continue;
      }
      Parent parent(record, quantum_m_);
      for (const Step& step : children)
        if (const Record* child = white_child({c, r}, step.direction, half))
          parent.add(*child, step.squared_m);
      greatest = std::max(greatest, parent.close());
    }
  }
  return greatest;
}

const Record* RecordGrid::white_child(Post p, Post direction, int half) const {
  if (half == 1) {
    const Post cell{p.col + (direction.col - 1) / 2, p.row + (direction.row - 1) / 2};
    if (cell.col < 0 || cell.row < 0 || cell.col >= cells_ || cell.row >= cells_) return nullptr;
    return holds(cell) ? &finer_[index(cell)] : nullptr;
  }
  const Post child{p.col + direction.col * (half / 2), p.row + direction.row * (half / 2)};
  return holds(child) ? &records_[index(child)] : nullptr;
}

// Middles of squares of 2 half; their children are the midpoints of the four sides.
Code RecordGrid::nest_white(int half) {
  Code greatest = 0;
  const auto children = steps(kAxes, std::ldexp(half, log2_spacing_));
  for (int r = first_at(region_.row0, 2 * half, half); r < region_.row1; r += 2 * half) {
    for (int c = first_at(region_.col0, 2 * half, half); c < region_.col1; c += 2 * half) {
      Parent parent(records_[index({c, r})], quantum_m_);
      for (const Step& step : children) {
        const Post child{c + step.direction.col * half, r + step.direction.row * half};
        if (holds(child)) parent.add(records_[index(child)], step.squared_m);
      }
      greatest = std::max(greatest, parent.close());
    }
  }
  return greatest;
}

// The corners and the centre are drawn whatever lies below them, so they keep their heights.
void RecordGrid::finish() {
  const int n = cells_;
  for (const Post locked : {Post{0, 0}, Post{n, 0}, Post{0, n}, Post{n, n}, Post{n / 2, n / 2}}) {
    if (!holds(locked)) continue;
    Record& record = records_[index(locked)];
    record.delta = record.radius = kInfinite;
  }
  for (Record& record : records_)
    if (record.radius == kEmpty) record = {};
}

void RecordGrid::raise_maxima(std::span<Code> delta_max_of_depth) const {
  auto depth =
      static_cast<std::size_t>(static_cast<int>(delta_max_of_depth.size()) - 2 * log2_spacing_);
  for (const Code greatest : maxima_) {
    --depth;
    delta_max_of_depth[depth] = std::max(delta_max_of_depth[depth], greatest);
  }
}

}  // namespace arete::lod::bintree
