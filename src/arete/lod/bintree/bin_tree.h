#pragma once

#include <vector>

#include "arete/lod/bintree/code_counts.h"
#include "arete/lod/bintree/live_range.h"
#include "arete/lod/bintree/range_ends.h"
#include "arete/lod/bintree/triangle_list.h"
#include "arete/lod/bintree/vertex_array.h"
#include "arete/lod/bintree/walk.h"

namespace arete::lod::bintree {

/// Which vertices of the tree a frame looks at.
enum class Visit {
  Ended,  ///< those whose live range has ended: a frame costs what changes
  All,    ///< every one, to check its range: the paper
};

/// The bin-tree array: triangles in the order in which they were met, children in pairs
/// [BaoPajarolaShafae2004, 4.5]. It stays as it is between frames; a frame halves or mends the
/// triangles of those vertices whose status has changed.
class BinTree {
 public:
  struct Options {
    Visit visit = Visit::Ended;
    std::size_t capacity = std::size_t{1} << 16U;  ///< nodes, to begin with
  };
  /// They must outlive it.
  BinTree(Ground& ground, VertexArray& vertices, const Odometer& odometer, const Options& options);

  /// What a frame goes by.
  struct Frame {
    const Rule& rule;
    const Evaluation& evaluation;
    /// Re-evaluates culling where Figure 6 as printed does: on rotation.
    bool figure_6 = false;
  };
  /// Brings the tree up to date; indices() are of this frame then, in no order.
  Findings refine(const Frame& frame);
  std::span<const std::uint32_t> indices() const { return triangles_.indices(); }

  /// Pages that are not there and may be wanted soon: below triangles drawn whole whose vertices'
  /// live ranges are about to end. Kept under OnMissing::Defer only.
  std::span<const std::uint64_t> pages_ahead() const { return pages_ahead_; }

  /// Ends all live ranges.
  void expire();
  /// Keeps the triangles that are drawn or halved, in depth-first order, and their vertices.
  /// Doubles the capacity when it is more than half full of them. The vertices' key changes.
  void collect();
  bool is_full() const { return nodes_.size() > capacity_; }

 private:
  enum class State : std::uint8_t { Out, Whole, Halved };
  /// A triangle: apex, base from left to right, halved by `vertex`; slots of the vertex array.
  struct Node {
    std::uint32_t apex = 0, left = 0, right = 0;
    std::uint32_t vertex = VertexArray::kNone;  ///< once it was found
    std::uint32_t child = 0;                    ///< the left one; the right one follows; 0 = none
    std::uint32_t place = 0;                    ///< in the list, while whole
    std::int8_t levels = 0;  ///< bisections that the domain has left, this one included
    State state = State::Out;
    bool waits = false;  ///< whole, and its vertex or an ancestor of that is not there
  };

  void settle(std::uint32_t node);
  void conform_halves(std::uint32_t vertex);
  void conform(std::uint32_t node);
  void halve(std::uint32_t node);
  void mend(std::uint32_t node);
  std::uint32_t leave(std::uint32_t node);

  void settle_waiting();
  void update_ended();
  Ticks renew(std::uint32_t vertex);
  void renew_below(std::uint32_t node);
  void count_late();

  VertexIndex index_of_vertex(std::uint32_t node) const;
  bool find_vertex(std::uint32_t node);
  bool lasts(std::uint32_t vertex) const;
  void evaluate(std::uint32_t vertex);
  void expect(std::uint32_t vertex);
  void expect_soon(std::uint32_t vertex);
  void look_ahead();
  void look_below(std::uint32_t vertex);
  void wait(std::uint32_t node);
  std::uint32_t children_of(std::uint32_t node);

  void enter(std::uint32_t node, std::uint32_t place);
  void draw(std::uint32_t node, std::uint32_t place);
  void uncount(const Node& whole);
  void free(std::uint32_t place);
  void make_room();
  void plant();
  void keep(std::uint32_t from, std::uint32_t to);

  Ground& ground_;
  VertexArray& vertices_;
  const Odometer& odometer_;
  Visit visit_;
  std::size_t capacity_;
  std::vector<Node> nodes_, old_nodes_;
  TriangleList triangles_;
  CodeCounts deltas_;  ///< of the vertices of whole triangles
  RangeEnds ends_;     ///< of the vertices' live ranges, by slot
  RangeEnds soon_;     ///< the same some frames earlier; under Defer only
  std::vector<std::uint32_t> changed_, waiting_, waited_;
  std::vector<std::uint64_t> pages_ahead_;
  Findings findings_;
  const Frame* frame_ = nullptr;
  bool looks_ahead_ = false;
};

}  // namespace arete::lod::bintree
