#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "arete/lod/bintree/pair_test.h"

namespace arete::lod::bintree {

/// A corner of a triangle on its way down the bin-tree.
struct Corner {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  Post post;
  float z = 0;                 ///< metres, as drawn
  std::uint32_t slot = kNone;  ///< of the vertex that a visitor made of it
};

inline Post middle_of(Post a, Post b) {
  return {(a.col + b.col) >> 1, (a.row + b.row) >> 1};
}

/// What a walk goes by.
struct Rule {
  const Criterion& criterion;
  const ScreenError& error;
  const RefineOptions& options;
};

/// What a walk met.
struct Findings {
  std::uint64_t visited = 0, evaluated = 0, culled = 0, late = 0;
  std::uint64_t halved = 0;  ///< triangles: 4 more are drawn
  Code delta = 0;            ///< largest of the triangles drawn whole
  /// Of triangles drawn whole because their vertex is missing: bounds by what is known above them.
  double late_error_m = 0, late_error_px = 0;

  /// Everything below a missing vertex lies in the ball of its triangle's apex and has no larger
  /// delta than that, nor than `delta_max`, the largest of the missing vertex's depth.
  void add_late(const Rule& rule, const Ball& apex, double delta_max) {
    ++late;
    const double error = std::min(apex.delta, delta_max);
    const double distance = glm::length(apex.centre - rule.criterion.eye()) - apex.radius;
    late_error_m = std::max(late_error_m, error);
    late_error_px = std::max(late_error_px, rule.error.pixels(error, std::max(distance, 0.0)));
  }
};

/// SOAR's refinement: every triangle from the top, every frame [LindstromPascucci2002]. A visitor
/// is told in the order of the strip:
///   visitor.begin(left)                  the first root's left corner
///   visitor.halving(corner, ball, l, r)  before the halves; may move the z of the corner, which
///                                        halves edge l r
///   visitor.halved(apex, levels)         between the two halves; levels = bisections left
///   visitor.whole(apex, left, right, levels)
///   visitor.root_done(right)             after each of the four roots, its right corner
template <typename Visitor>
class Walk {
 public:
  Walk(Ground& ground, const Rule& rule, Visitor& visitor)
      : ground_(ground),
        pages_(ground.pages()),
        rule_(rule),
        test_(ground, rule.criterion),
        on_missing_(rule.options.on_missing),
        inside_(rule.options.cull ? 0 : Criterion::kAllInside),
        visitor_(visitor) {}

  /// Restricts to what is there with its ancestors. Null: everything is.
  void use(Presence* presence) { presence_ = presence; }

  void refine_all() {
    Middle centre{corner_of(kCentre, ground_.centre()), kCentre, &ground_.centre(), true};
    std::array<Corner, 4> corners;
    for (std::size_t i = 0; i < 4; ++i)
      corners[i] = corner_of(kRootTriangles[i].left, ground_.corner(kRootTriangles[i].left));
    const Record* roots = pages_.find(kWest, on_missing_);
    visitor_.begin(corners[0]);
    for (std::size_t i = 0; i < 4; ++i) {
      const Triangle root{&centre.corner, &corners[i], &corners[(i + 1) % 4]};
      Middle m = middle(root, kRootTriangles[i].middle, roots);
      if (roots == nullptr || presence_ != nullptr) [[unlikely]]
        leave_out_missing(m, centre, ground_.domain().depths() - 1);
      test(m, m);
      refine(centre, root, m, ground_.domain().depths() - 1, inside_);
      visitor_.root_done(*root.right);
    }
    findings_.visited += 4;
    findings_.evaluated = findings_.visited - findings_.late;
  }
  const Findings& findings() const { return findings_; }

 private:
  /// A triangle, its base from left to right.
  struct Triangle {
    Corner *apex, *left, *right;
  };
  /// The vertex that halves a triangle.
  struct Middle {
    Corner corner;
    VertexIndex index;
    const Record* record;
    bool selected;
  };
  /// Stands for the records of a page that is missing: nothing selects it.
  static constexpr std::array<Record, 4> kMissing{};

  Corner corner_of(VertexIndex vertex, const Record& record) const {
    return {ground_.domain().post_of(vertex), static_cast<float>(ground_.z_of(record))};
  }

  // g: number of the triangle's middle; `four`: the records of g's parent's children, which share
  // a page, or null.
  static Middle middle(const Triangle& t, VertexIndex g, const Record* four) {
    const Record* record = &(four != nullptr ? four : kMissing.data())[g & 3U];
    return {{middle_of(t.left->post, t.right->post)}, g, record, false};
  }
  void test(Middle& a, Middle& b) const {
    const PairTest::Answers answers = test_(a.corner.post, *a.record, b.corner.post, *b.record);
    a.corner.z = answers.z_a;
    b.corner.z = answers.z_b;
    a.selected = answers.a;
    b.selected = answers.b;
  }

  // What hangs on a missing vertex by its other parent is left out as well.
  void leave_out_missing(Middle& m, const Middle& apex, int levels) {
    if (m.record != &kMissing[m.index & 3U] &&
        (presence_ == nullptr || presence_->whole(m.index, m.corner.post)))
      return;
    m.record = kMissing.data();
    findings_.add_late(rule_, ground_.ball(apex.corner.post, *apex.record),
                       pages_.delta_max(ground_.domain().depths() - levels));
  }

  // p: the triangle's apex; `levels`: bisections that the domain has left, m's included; `inside`:
  // planes that p's ball lies inside. Inlined: half of all triangles are drawn whole, which takes
  // less time than a call.
  [[gnu::always_inline]] void refine(const Middle& p, const Triangle& t, Middle& m, int levels,
                                     unsigned inside) {
    if (m.selected && is_seen(m, inside)) return halve(p.index, t, m, levels, inside);
    findings_.delta = std::max(findings_.delta, m.record->delta);
    visitor_.whole(*t.apex, *t.left, *t.right, levels);
  }

  bool is_seen(const Middle& m, unsigned& inside) {
    if (inside == Criterion::kAllInside) return true;
    if (rule_.criterion.visible(ground_.ball(m.corner.post, *m.record), inside)) return true;
    ++findings_.culled;
    return false;
  }

  void halve(VertexIndex p, const Triangle& t, Middle& m, int levels, unsigned inside) {
    ++findings_.halved;
    visitor_.halving(m.corner, ground_.ball(m.corner.post, *m.record), *t.left, *t.right);
    const Triangle left{&m.corner, t.left, t.apex};
    const Triangle right{&m.corner, t.apex, t.right};
    if (levels == 1) {
      visitor_.whole(*left.apex, *left.left, *left.right, 0);
      visitor_.halved(*t.apex, levels);
      return visitor_.whole(*right.apex, *right.left, *right.right, 0);
    }
    findings_.visited += 2;
    const Record* four = pages_.find(4 * p, on_missing_);
    Middle of_left = middle(left, left_child(p, m.index), four);
    Middle of_right = middle(right, right_child(p, m.index), four);
    if (four == nullptr || presence_ != nullptr) [[unlikely]] {
      leave_out_missing(of_left, m, levels - 1);
      leave_out_missing(of_right, m, levels - 1);
    }
    // Both before either is refined: so their loads and sums overlap, and the answers are there
    // when they are branched on.
    test(of_left, of_right);
    refine(m, left, of_left, levels - 1, inside);
    visitor_.halved(*t.apex, levels);
    refine(m, right, of_right, levels - 1, inside);
  }

  Ground& ground_;
  RecordPages& pages_;
  Rule rule_;
  PairTest test_;
  OnMissing on_missing_;
  unsigned inside_;
  Visitor& visitor_;
  Presence* presence_ = nullptr;
  Findings findings_;
};

}  // namespace arete::lod::bintree
