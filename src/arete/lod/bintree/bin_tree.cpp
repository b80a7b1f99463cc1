#include "arete/lod/bintree/bin_tree.h"

#include <algorithm>

namespace arete::lod::bintree {
namespace {

constexpr std::uint32_t kRoots = 4;

Ticks earlier(const Ticks& a, const Ticks& b) {
  return {std::min(a[Move], b[Move]), std::min(a[Scale], b[Scale]), std::min(a[Turn], b[Turn])};
}

}  // namespace

BinTree::BinTree(Ground& ground, VertexArray& vertices, const Options& options)
    : ground_(ground),
      vertices_(vertices),
      reuse_(options.reuse),
      capacity_(options.capacity),
      nodes_(kRoots) {
  make_room();
}

// For the capacity and what one frame may add: so that frames allocate nothing once warm.
void BinTree::make_room() {
  const std::size_t nodes = capacity_ + capacity_ / 2;
  nodes_.reserve(nodes);
  old_nodes_.reserve(nodes);
  vertices_.reserve(nodes);
}

BinTree::Triangle BinTree::root(std::size_t i) const {
  const RootTriangle& r = kRootTriangles[i];
  const auto slot = [](VertexIndex corner) {
    return VertexArray::kFirstCornerSlot + static_cast<std::uint32_t>(corner - kSouthWest);
  };
  return {kCentre,      r.middle,      VertexArray::kCentreSlot,
          slot(r.left), slot(r.right), ground_.domain().depths() - 1};
}

Findings BinTree::refine(const Frame& frame) {
  frame_ = &frame;
  findings_ = {};
  pages_ahead_.clear();
  indices_.begin();
  std::array<std::uint32_t, kRoots> counts;
  for (std::uint32_t i = 0; i < kRoots; ++i) counts[i] = nodes_[i].indices;
  std::uint32_t at = 0;
  for (std::uint32_t i = 0; i < kRoots; ++i) {
    visit(i, root(i), {!fresh_, at});
    at += counts[i];
    findings_.delta = std::max(findings_.delta, nodes_[i].delta);
  }
  fresh_ = false;
  indices_.end();
  findings_.halved = indices_.all().size() / 3 - kRoots;
  return findings_;
}

void BinTree::visit(std::uint32_t node, const Triangle& t, Before before) {
  Node& n = nodes_[node];
  if (before.drawn && reuse_ == Reuse::Subtrees && alive(frame_->odometer.now(), n.until)) {
    indices_.copy(before.at, n.indices);
    return;
  }
  ++findings_.visited;
  const Status status = status_of(n, t, before);
  if (status == Status::Halved) return draw_halves(node, t, before);
  draw_whole(n, t, before);
  if (status == Status::Late) count_late(t);
}

// A node remembers how long its vertex's status lasts, so those on the way to a change look at
// nothing else.
BinTree::Status BinTree::status_of(Node& node, const Triangle& t, Before before) {
  if (before.drawn && !frame_->figure_6 && alive(frame_->odometer.now(), node.own))
    return node.halved ? Status::Halved : Status::Whole;
  const bool there = find_vertex(node, t);
  const LiveVertex* vertex = there ? &vertices_.live(node.vertex) : nullptr;
  node.own = there ? vertex->until : Ticks{};
  node.own_delta = there ? vertex->record.delta : Code{0};
  if (!there) return Status::Late;
  if (vertex->active()) return Status::Halved;
  if (vertex->visible && t.levels > 1) look_ahead(t);
  return Status::Whole;
}

// A range that just ended and left the triangle whole is a short one again: it may be halved soon.
void BinTree::look_ahead(const Triangle& t) {
  if (frame_->rule.options.on_missing != OnMissing::Defer) return;
  for (const VertexIndex child : {left_child(t.p, t.g), right_child(t.p, t.g)}) {
    const std::uint64_t page = RecordPages::page_of(child);
    if (pages_ahead_.empty() || pages_ahead_.back() != page) pages_ahead_.push_back(page);
  }
}

// Brings the vertex's status up to date. False when the vertex or an ancestor is not there.
bool BinTree::find_vertex(Node& node, const Triangle& t) {
  if (node.vertex == VertexArray::kNone) {
    node.vertex =
        vertices_.acquire(t.g, middle_of(vertices_.post(t.left), vertices_.post(t.right)));
    if (node.vertex == VertexArray::kNone) return false;
  }
  const LiveVertex& vertex = vertices_.live(node.vertex);
  const bool dead = !alive(frame_->odometer.now(), vertex.until);
  // "If v's bounding sphere overlaps the view volume and d_tau is not negative, d_c is
  // re-evaluated [...] when v is not completely within" [BaoPajarolaShafae2004, 4.4 and Figure 6]:
  // by the flags from before the rotation.
  const bool doubted = frame_->figure_6 && vertex.selected && vertex.visible && !vertex.inside;
  if (!dead && !doubted) return true;
  evaluate(node.vertex);
  if (!vertex.selected || !vertex.visible || vertices_.root(node.vertex)) return true;
  vertices_.live(node.vertex).until = {};
  return false;
}

void BinTree::evaluate(std::uint32_t slot) {
  ++findings_.evaluated;
  LiveVertex& vertex = vertices_.live(slot);
  frame_->evaluation(vertices_.ball(slot), vertex);
  if (vertex.selected && !vertex.visible) ++findings_.culled;
}

void BinTree::draw_whole(Node& node, const Triangle& t, Before before) {
  if (before.drawn && !node.halved) {
    indices_.copy(before.at, 3);  // as it was: the stretch goes on
  } else {
    // Triangles of odd depth are wound counter-clockwise (vertex_index.h), and depths are even in
    // number.
    const bool turn = (t.levels & 1) == 0;
    indices_.triangle(t.apex, turn ? t.right : t.left, turn ? t.left : t.right);
  }
  node.indices = 3;
  node.halved = false;
  node.until = node.own;
  node.delta = node.own_delta;
}

void BinTree::count_late(const Triangle& t) {
  findings_.add_late(frame_->rule, vertices_.ball(t.apex),
                     ground_.pages().delta_max(ground_.domain().depths() - t.levels));
}

// The halves of the last bisection have no vertices to look at.
void BinTree::draw_last_halves(Node& node, const Triangle& t, Before before) {
  if (before.drawn && node.halved) {
    indices_.copy(before.at, 6);
  } else {
    indices_.triangle(node.vertex, t.apex, t.left);
    indices_.triangle(node.vertex, t.right, t.apex);
  }
  node.until = node.own;
  node.indices = 6;
  node.delta = 0;
  node.halved = true;
}

void BinTree::draw_halves(std::uint32_t node, const Triangle& t, Before before) {
  if (t.levels == 1) return draw_last_halves(nodes_[node], t, before);
  const std::uint32_t middle = nodes_[node].vertex;
  const std::uint32_t child = children_of(node);
  const bool drawn = before.drawn && nodes_[node].halved;
  const std::uint32_t right_at = before.at + nodes_[child].indices;
  visit(child, {t.g, left_child(t.p, t.g), middle, t.left, t.apex, t.levels - 1},
        {drawn, before.at});
  visit(child + 1, {t.g, right_child(t.p, t.g), middle, t.apex, t.right, t.levels - 1},
        {drawn, right_at});
  const Node& left = nodes_[child];
  const Node& right = nodes_[child + 1];
  Node& n = nodes_[node];
  n.until = earlier(n.own, earlier(left.until, right.until));
  n.indices = left.indices + right.indices;
  n.delta = std::max(left.delta, right.delta);
  n.halved = true;
}

std::uint32_t BinTree::children_of(std::uint32_t node) {
  if (nodes_[node].child == 0) {
    nodes_[node].child = static_cast<std::uint32_t>(nodes_.size());
    nodes_.resize(nodes_.size() + 2);
  }
  return nodes_[node].child;
}

void BinTree::collect() {
  old_nodes_.swap(nodes_);
  nodes_.assign(kRoots, {});
  vertices_.begin_collection();
  for (std::uint32_t i = 0; i < kRoots; ++i) keep_subtree(i, i, kCentre, kRootTriangles[i].middle);
  vertices_.end_collection();
  old_nodes_.clear();
  fresh_ = true;
  if (2 * nodes_.size() <= capacity_) return;
  capacity_ *= 2;
  make_room();
}

void BinTree::keep_subtree(std::uint32_t from, std::uint32_t to, VertexIndex p, VertexIndex g) {
  nodes_[to] = old_nodes_[from];
  nodes_[to].vertex = vertices_.keep(old_nodes_[from].vertex, g);
  const std::uint32_t child = old_nodes_[from].child;
  if (!old_nodes_[from].halved || child == 0) {
    nodes_[to].child = 0;
    return;
  }
  nodes_[to].child = 0;
  const std::uint32_t kept = children_of(to);
  keep_subtree(child, kept, g, left_child(p, g));
  keep_subtree(child + 1, kept + 1, g, right_child(p, g));
}

}  // namespace arete::lod::bintree
