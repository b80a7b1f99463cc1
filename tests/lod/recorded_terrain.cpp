#include "lod/recorded_terrain.h"

#include <cmath>
#include <functional>
#include <utility>

#include <fmt/format.h>

#include "arete/lod/bintree/record_pages.h"

namespace arete::lod::bintree {
namespace {

struct Triangle {
  Post apex, left, right;
  Post middle() const { return {(left.col + right.col) / 2, (left.row + right.row) / 2}; }
};

void visit_triangles(const Triangle& t, int depth, int depths,
                     const std::function<void(const Triangle&)>& visit) {
  visit(t);
  if (depth + 1 == depths) return;
  visit_triangles({t.middle(), t.left, t.apex}, depth + 1, depths, visit);
  visit_triangles({t.middle(), t.apex, t.right}, depth + 1, depths, visit);
}

// Barycentric shares of apex, left and right.
std::array<double, 3> shares(const Triangle& t, Post p) {
  const auto area = [](Post a, Post b, Post c) {
    return static_cast<double>(b.col - a.col) * (c.row - a.row) -
           static_cast<double>(c.col - a.col) * (b.row - a.row);
  };
  const double whole = area(t.apex, t.left, t.right);
  return {area(p, t.left, t.right) / whole, area(t.apex, p, t.right) / whole,
          area(t.apex, t.left, p) / whole};
}

class Checker {
 public:
  Checker(AllRecords& records, const RecordedTerrain& recorded, Delta delta)
      : records_(records), recorded_(recorded), delta_(delta), side_(records.domain().side()) {
    const auto posts = static_cast<std::size_t>((side_ + 1) * (side_ + 1));
    least_.resize(posts);
    lands_.resize(posts);
    slopes_.resize(posts);
  }

  std::vector<std::string> run() {
    for_each_triangle([&](const Triangle& t) { measure(t); });
    // Children come after their parents in no simple order: saturate until nothing moves.
    for (bool moved = true; moved;) {
      moved = false;
      for_each_triangle([&](const Triangle& t) { moved = saturate(t) || moved; });
    }
    for_each_triangle([&](const Triangle& t) { check_nesting(t); });
    for (int r = 0; r <= side_; ++r)
      for (int c = 0; c <= side_; ++c) check_record({c, r});
    return std::move(faults_);
  }

 private:
  void for_each_triangle(const std::function<void(const Triangle&)>& visit) {
    const Post centre{side_ / 2, side_ / 2};
    for (const RootTriangle& root : kRootTriangles)
      visit_triangles(
          {centre, records_.domain().post_of(root.left), records_.domain().post_of(root.right)}, 1,
          records_.domain().depths(), visit);
  }

  std::size_t at(Post p) const { return static_cast<std::size_t>(p.row * (side_ + 1) + p.col); }
  bool counts(Post p) const {
    const Heightfield& dem = recorded_.dem();
    for (const Post cell : {Post{p.col - 1, p.row - 1}, Post{p.col, p.row - 1},
                            Post{p.col - 1, p.row}, Post{p.col, p.row}}) {
      if (cell.col >= 0 && cell.row >= 0 && cell.col + 1 < dem.cols() &&
          cell.row + 1 < dem.rows() && dem.drawable(cell))
        return true;
    }
    return false;
  }
  double z(Post p) { return recorded_.terrain().z_of(records_[p].count); }

  // The base vertex's own delta over the posts of the triangle, and whether there are any.
  void measure(const Triangle& t) {
    const std::size_t m = at(t.middle());
    const auto [col0, col1] = std::minmax({t.apex.col, t.left.col, t.right.col});
    const auto [row0, row1] = std::minmax({t.apex.row, t.left.row, t.right.row});
    for (int r = row0; r <= row1; ++r) {
      for (int c = col0; c <= col1; ++c) {
        const auto s = shares(t, {c, r});
        if (std::min({s[0], s[1], s[2]}) < 0 || !counts({c, r})) continue;
        if (std::max({s[0], s[1], s[2]}) == 1) continue;  // a corner is drawn as it is
        lands_[m] = 1;
        if (delta_ == Delta::Incremental) continue;
        const double plane = s[0] * z(t.apex) + s[1] * z(t.left) + s[2] * z(t.right);
        least_[m] = std::max(least_[m], std::abs(plane - recorded_.dem()[{c, r}]));
      }
    }
    if (delta_ == Delta::Incremental)
      least_[m] = std::abs(z(t.middle()) - (z(t.left) + z(t.right)) / 2);
    if (z(t.apex) != z(t.left) || z(t.left) != z(t.right)) slopes_[m] = 1;
  }

  bool saturate(const Triangle& t) {
    if (is_finest(t)) return false;
    bool moved = false;
    const std::size_t m = at(t.middle());
    for (const Post child : children(t)) {
      const std::size_t c = at(child);
      moved = moved || (lands_[c] != 0 && least_[c] > least_[m]) || lands_[c] > lands_[m] ||
              slopes_[c] > slopes_[m];
      least_[m] = std::max(least_[m], lands_[c] != 0 ? least_[c] : 0);
      lands_[m] = std::max(lands_[m], lands_[c]);
      slopes_[m] = std::max(slopes_[m], slopes_[c]);
    }
    return moved;
  }

  static bool is_finest(const Triangle& t) {
    return (t.left.col + t.apex.col) % 2 != 0 || (t.left.row + t.apex.row) % 2 != 0;
  }
  static std::array<Post, 2> children(const Triangle& t) {
    return {Post{(t.left.col + t.apex.col) / 2, (t.left.row + t.apex.row) / 2},
            Post{(t.right.col + t.apex.col) / 2, (t.right.row + t.apex.row) / 2}};
  }

  void check_nesting(const Triangle& t) {
    if (is_finest(t)) return;
    const Record& v = records_[t.middle()];
    for (const Post post : children(t)) {
      const Record& child = records_[post];
      if (lands_[at(post)] == 0) continue;
      const auto& affine = recorded_.dem().georef().world_from_post;
      const auto a = affine.apply(t.middle().col, t.middle().row);
      const auto b = affine.apply(post.col, post.row);
      const double distance = std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y) +
                                        (z(t.middle()) - z(post)) * (z(t.middle()) - z(post)));
      if (value(v.radius) < distance + value(child.radius))
        fault(t.middle(),
              fmt::format("radius {} < {} + {}", value(v.radius), distance, value(child.radius)));
      if (v.delta < child.delta) fault(t.middle(), "delta less than a child's");
    }
  }

  void check_record(Post p) {
    const Record& record = records_[p];
    const int half = side_ / 2;
    if ((p.col % side_ == 0 && p.row % side_ == 0) || (p.col == half && p.row == half)) {
      if (record.delta != kInfinite || record.radius != kInfinite) fault(p, "is not locked");
      return;
    }
    if (lands_[at(p)] == 0) {
      if (record.delta != 0 || record.radius != 0) fault(p, "has no land, but a record");
      return;
    }
    if (counts(p) && static_cast<float>(z(p)) != recorded_.dem()[p]) fault(p, "another height");
    const double most = largest_z() * 0x1p-23;
    const double least = least_[at(p)];
    if (value(record.delta) < least + (least > 0 ? most : 0))
      fault(p, fmt::format("delta {} < {}", value(record.delta), least));
    const double bound = least > 0 || slopes_[at(p)] != 0 ? (least + most) * (1 + 0x1p-8) : 0;
    if (value(record.delta) > bound * (1 + 1e-9))
      fault(p, fmt::format("delta {} > {}", value(record.delta), bound));
  }

  double largest_z() const {
    const store::Manifest& m = recorded_.terrain().manifest();
    return std::max(std::abs(m.z_min), std::abs(m.z_max));
  }

  void fault(Post p, const std::string& what) {
    faults_.push_back(fmt::format("post ({}, {}): {}", p.col, p.row, what));
  }

  AllRecords& records_;
  const RecordedTerrain& recorded_;
  Delta delta_;
  int side_;
  std::vector<double> least_;                 // by post, saturated
  std::vector<std::uint8_t> lands_, slopes_;  // a drawable post; a triangle that is not level
  std::vector<std::string> faults_;
};

}  // namespace

RecordedTerrain::RecordedTerrain(Heightfield dem, const RecordOptions& options,
                                 const BuildContext& context)
    : dem_(std::move(dem)) {
  store::BuildOptions build_options;
  build_options.output = store();
  build_options.source_key = "test";
  build_options.preprocess = [&](const store::Terrain& terrain, store::Writers& writers) {
    write_records(terrain, writers, context, options);
  };
  store::build(dem_, build_options, context);
  terrain_ = store::Terrain::open(store());
  dem_ = Heightfield(*terrain_->height_source());
}

AllRecords::AllRecords(const store::Terrain& terrain, Delta delta)
    : domain_(Domain::over(terrain.manifest().cols, terrain.manifest().rows)) {
  RecordPages pages(terrain, {.delta = delta, .prefetch = Prefetch::Off});
  for (int r = 0; r <= domain_.side(); ++r)
    for (int c = 0; c <= domain_.side(); ++c)
      records_.push_back(*pages.find(domain_.index_of({c, r}), OnMissing::Wait));
}

std::vector<std::string> find_faults(AllRecords& records, const RecordedTerrain& recorded,
                                     Delta delta) {
  return Checker(records, recorded, delta).run();
}

}  // namespace arete::lod::bintree
