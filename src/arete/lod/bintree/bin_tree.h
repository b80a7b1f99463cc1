#pragma once

#include <array>
#include <vector>

#include "arete/lod/bintree/index_list.h"
#include "arete/lod/bintree/live_range.h"
#include "arete/lod/bintree/vertex_array.h"
#include "arete/lod/bintree/walk.h"

namespace arete::lod::bintree {

/// What a tree does with live ranges.
enum class Reuse {
  Subtrees,  ///< a subtree all of whose ranges last is copied, not visited [METHODS 8.11]
  Statuses,  ///< every node is visited and its range checked: the paper
};

/// The bin-tree array: nodes in the order in which they were met, children in pairs, with the
/// triangles of the frame before [BaoPajarolaShafae2004, 4.5].
class BinTree {
 public:
  struct Options {
    Reuse reuse = Reuse::Subtrees;
    std::size_t capacity = std::size_t{1} << 16U;  ///< nodes, to begin with
  };
  BinTree(Ground& ground, VertexArray& vertices, const Options& options);

  /// What a frame goes by.
  struct Frame {
    const Rule& rule;
    const Odometer& odometer;
    const Evaluation& evaluation;
    /// Re-evaluates culling where Figure 6 as printed does: on rotation.
    bool figure_6 = false;
  };
  /// Refines the four root triangles; indices() are of this frame then.
  Findings refine(const Frame& frame);
  std::span<const std::uint32_t> indices() const { return indices_.all(); }

  /// Pages of vertices that the next frames may ask for: below what is drawn whole and whose range
  /// ended in this frame. Kept under OnMissing::Defer only.
  std::span<const std::uint64_t> pages_ahead() const { return pages_ahead_; }

  /// The next frame visits every node.
  void forget_triangles() { fresh_ = true; }
  /// Keeps the nodes of the latest frame, in depth-first order, and their vertices. Doubles the
  /// capacity when it is more than half full of them. The vertices' key changes.
  void collect();
  bool is_full() const { return nodes_.size() > capacity_; }
  std::size_t size() const { return nodes_.size(); }
  std::size_t bytes() const { return nodes_.capacity() * sizeof(Node); }

 private:
  /// A triangle of the bin-tree, and what was drawn of it in the latest frame that drew it.
  struct Node {
    std::uint32_t child = 0;  ///< the left one; the right one follows; 0 = none yet
    std::uint32_t vertex = VertexArray::kNone;  ///< that halves it
    Ticks until{};                              ///< least of the subtree drawn
    Ticks own{};                                ///< of its vertex alone, when last looked at
    std::uint32_t indices = 0;                  ///< drawn
    Code delta = 0;                             ///< largest of the triangles drawn whole
    Code own_delta = 0;                         ///< of its vertex
    bool halved = false;
  };
  /// A node's triangle: apex p, base from left to right, halved by g.
  struct Triangle {
    VertexIndex p, g;
    std::uint32_t apex, left, right;
    int levels;  ///< bisections that the domain has left, this one included
  };
  /// Where the frame before drew it; not drawn = it must be visited.
  struct Before {
    bool drawn;
    std::uint32_t at;
  };

  void visit(std::uint32_t node, const Triangle& t, Before before);
  /// What a frame makes of a triangle.
  enum class Status { Halved, Whole, Late };
  Status status_of(Node& node, const Triangle& t, Before before);
  bool find_vertex(Node& node, const Triangle& t);
  void draw_whole(Node& node, const Triangle& t, Before before);
  void draw_last_halves(Node& node, const Triangle& t, Before before);
  void count_late(const Triangle& t);
  void look_ahead(const Triangle& t);
  void draw_halves(std::uint32_t node, const Triangle& t, Before before);
  void evaluate(std::uint32_t slot);
  std::uint32_t children_of(std::uint32_t node);
  void make_room();
  void keep_subtree(std::uint32_t from, std::uint32_t to, VertexIndex p, VertexIndex g);
  Triangle root(std::size_t i) const;

  Ground& ground_;
  VertexArray& vertices_;
  Reuse reuse_;
  std::size_t capacity_;
  std::vector<Node> nodes_, old_nodes_;
  IndexList indices_;
  std::vector<std::uint64_t> pages_ahead_;
  Findings findings_;
  const Frame* frame_ = nullptr;
  bool fresh_ = true;
};

}  // namespace arete::lod::bintree
