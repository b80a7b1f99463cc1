#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "arete/lod/bintree/ground.h"

namespace arete::lod::bintree {

/// A corner of a triangle on its way down the bin-tree.
struct Corner {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  Post post;
  float z = 0;                 ///< metres, as drawn
  std::uint32_t slot = kNone;  ///< of the vertex that a visitor made of it
};

inline Post middle_of(Post a, Post b) {
  return {(a.col + b.col) / 2, (a.row + b.row) / 2};
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
///   visitor.halved(apex, levels)         between the two halves; levels = bisections left
///   visitor.whole(apex, left, right, levels)
///   visitor.root_done(right)             after each of the four roots, its right corner
///   visitor.morph(corner, ball, l, r)    may move the corner's z; the corner halves edge l r
template <typename Visitor>
class Walk {
 public:
  Walk(Ground& ground, const Rule& rule, Visitor& visitor)
      : ground_(ground),
        pages_(ground.pages()),
        rule_(rule),
        on_missing_(rule.options.on_missing),
        inside_(rule.options.cull ? 0 : Criterion::kAllInside),
        visitor_(visitor) {}

  /// Restricts to what is there with its ancestors. Null: everything is.
  void use(Presence* presence) { presence_ = presence; }

  void refine_all() {
    Corner centre = corner_of(kCentre, ground_.centre());
    const Ball ball = ground_.ball(centre.post, ground_.centre());
    std::array<Corner, 4> corners;
    for (std::size_t i = 0; i < 4; ++i)
      corners[i] = corner_of(kRootTriangles[i].left, ground_.corner(kRootTriangles[i].left));
    visitor_.begin(corners[0]);
    for (std::size_t i = 0; i < 4; ++i) {
      Corner& right = corners[(i + 1) % 4];
      half({kCentre, kRootTriangles[i].middle, &ball, &centre, &corners[i], &right},
           ground_.domain().depths() - 1, inside_);
      visitor_.root_done(right);
    }
  }
  const Findings& findings() const { return findings_; }

 private:
  /// A triangle: apex p, base from left to right, halved by g.
  struct Half {
    VertexIndex p, g;
    const Ball* apex_ball;
    Corner *apex, *left, *right;
  };

  Corner corner_of(VertexIndex vertex, const Record& record) const {
    return {ground_.domain().post_of(vertex), static_cast<float>(ground_.z_of(record))};
  }

  // `levels`: bisections that the domain has left, this one included.
  void half(const Half& t, int levels, unsigned inside) {
    ++findings_.visited;
    Corner middle{middle_of(t.left->post, t.right->post)};
    const Record* record = pages_.find(t.g, on_missing_);
    if (record == nullptr || (presence_ != nullptr && !presence_->whole(t.g, middle.post)))
        [[unlikely]] {
      count_late(t, levels);
      visitor_.whole(*t.apex, *t.left, *t.right, levels);
      return;
    }
    const Ball ball = ground_.ball(middle.post, *record);
    if (!active(ball, inside)) {
      findings_.delta = std::max(findings_.delta, record->delta);
      visitor_.whole(*t.apex, *t.left, *t.right, levels);
      return;
    }
    ++findings_.halved;
    middle.z = static_cast<float>(ball.centre.z);
    visitor_.morph(middle, ball, *t.left, *t.right);
    if (levels == 1) {
      visitor_.whole(middle, *t.left, *t.apex, 0);
      visitor_.halved(*t.apex, levels);
      visitor_.whole(middle, *t.apex, *t.right, 0);
      return;
    }
    half({t.g, left_child(t.p, t.g), &ball, &middle, t.left, t.apex}, levels - 1, inside);
    visitor_.halved(*t.apex, levels);
    half({t.g, right_child(t.p, t.g), &ball, &middle, t.apex, t.right}, levels - 1, inside);
  }

  bool active(const Ball& ball, unsigned& inside) {
    ++findings_.evaluated;
    if (!rule_.criterion.selected(ball)) return false;
    if (rule_.criterion.visible(ball, inside)) return true;
    ++findings_.culled;
    return false;
  }

  void count_late(const Half& t, int levels) {
    findings_.add_late(rule_, *t.apex_ball, pages_.delta_max(ground_.domain().depths() - levels));
  }

  Ground& ground_;
  RecordPages& pages_;
  Rule rule_;
  OnMissing on_missing_;
  unsigned inside_;
  Visitor& visitor_;
  Presence* presence_ = nullptr;
  Findings findings_;
};

}  // namespace arete::lod::bintree
