#include "arete/lod/bintree/bin_tree.h"

#include <algorithm>

namespace arete::lod::bintree {
namespace {

constexpr std::uint32_t kRoots = 4;
constexpr std::uint32_t kNone = VertexArray::kNone;
// How long before the end of a range what lies below is asked for, and how much of that waits.
constexpr double kFramesAhead = 32;
constexpr std::size_t kMostAhead = 1024;

}  // namespace

BinTree::BinTree(Ground& ground, VertexArray& vertices, const Odometer& odometer,
                 const Options& options)
    : ground_(ground),
      vertices_(vertices),
      odometer_(odometer),
      visit_(options.visit),
      capacity_(options.capacity) {
  make_room();
  plant();
}

// For the capacity and what one frame may add: so that frames allocate nothing once warm.
void BinTree::make_room() {
  const std::size_t nodes = capacity_ + capacity_ / 2;
  nodes_.reserve(nodes);
  old_nodes_.reserve(nodes);
  vertices_.reserve(nodes);
  triangles_.reserve(nodes);
  ends_.reserve(nodes);
  soon_.reserve(nodes);
  for (std::vector<std::uint32_t>* list : {&changed_, &waiting_, &waited_}) list->reserve(nodes);
}

// The four root triangles, to be looked at by the first frame.
void BinTree::plant() {
  const auto slot = [](VertexIndex corner) {
    return VertexArray::kFirstCornerSlot + static_cast<std::uint32_t>(corner - kSouthWest);
  };
  for (std::uint32_t i = 0; i < kRoots; ++i) {
    nodes_.push_back({.apex = VertexArray::kCentreSlot,
                      .left = slot(kRootTriangles[i].left),
                      .right = slot(kRootTriangles[i].right),
                      .levels = static_cast<std::int8_t>(ground_.domain().depths() - 1)});
    draw(i, triangles_.add());
    wait(i);
  }
}

Findings BinTree::refine(const Frame& frame) {
  frame_ = &frame;
  findings_ = {};
  looks_ahead_ = frame.rule.options.on_missing == OnMissing::Defer;
  settle_waiting();
  update_ended();
  if (looks_ahead_) look_ahead();
  count_late();
  findings_.delta = deltas_.greatest();
  findings_.halved = triangles_.size() - kRoots;
  return findings_;
}

void BinTree::settle_waiting() {
  waited_.swap(waiting_);
  waiting_.clear();
  for (const std::uint32_t node : waited_) {
    nodes_[node].waits = false;
    if (nodes_[node].state == State::Whole) settle(node);
  }
}

// All statuses first, then the triangles.
void BinTree::update_ended() {
  changed_.clear();
  if (visit_ == Visit::Ended) {
    ends_.renew_ended(odometer_.now(), [this](std::uint32_t vertex) {
      ++findings_.visited;
      return renew(vertex);
    });
  } else {
    for (std::uint32_t i = 0; i < kRoots; ++i) renew_below(i);
  }
  for (const std::uint32_t vertex : changed_) conform_halves(vertex);
}

// Those that the tree has left are forgotten; they are evaluated anew when they come back.
Ticks BinTree::renew(std::uint32_t vertex) {
  if (!vertices_.is_attached(vertex)) return RangeEnds::kNever;
  LiveVertex& v = vertices_.live(vertex);
  const bool was_wanted = v.wanted();
  evaluate(vertex);
  if (v.wanted() != was_wanted) changed_.push_back(vertex);
  expect_soon(vertex);
  return v.until;
}

void BinTree::renew_below(std::uint32_t node) {
  const Node& n = nodes_[node];
  if (n.levels == 0) return;
  ++findings_.visited;
  if (n.vertex != kNone && !lasts(n.vertex)) renew(n.vertex);
  if (n.state != State::Halved) return;
  renew_below(n.child);
  renew_below(n.child + 1);
}

void BinTree::count_late() {
  std::erase_if(waiting_, [&](std::uint32_t node) {
    Node& n = nodes_[node];
    n.waits = n.waits && n.state == State::Whole &&
              (n.vertex == kNone || vertices_.live(n.vertex).wanted());
    return !n.waits;
  });
  for (const std::uint32_t node : waiting_) {
    const Node& n = nodes_[node];
    findings_.add_late(frame_->rule, vertices_.ball(n.apex),
                       ground_.pages().delta_max(ground_.domain().depths() - n.levels));
  }
}

// A triangle that was not looked at in this frame.
void BinTree::settle(std::uint32_t node) {
  if (nodes_[node].levels == 0) return;
  ++findings_.visited;
  if (!find_vertex(node)) return wait(node);
  const std::uint32_t vertex = nodes_[node].vertex;
  const bool lasted = lasts(vertex);
  if (!lasted) evaluate(vertex);
  expect(vertex);
  lasted ? conform(node) : conform_halves(vertex);
}

void BinTree::conform_halves(std::uint32_t vertex) {
  for (std::size_t i = 0; i < 2; ++i) {
    const std::uint32_t node = vertices_.halves(vertex)[i];
    if (node != kNone) conform(node);
  }
}

void BinTree::conform(std::uint32_t node) {
  const std::uint32_t vertex = nodes_[node].vertex;
  const bool halved = nodes_[node].state == State::Halved;
  if (!vertices_.live(vertex).wanted()) {
    if (halved) mend(node);
  } else if (!halved) {
    vertices_.root(vertex) ? halve(node) : wait(node);
  }
}

void BinTree::halve(std::uint32_t node) {
  const std::uint32_t child = children_of(node);
  uncount(nodes_[node]);
  nodes_[node].state = State::Halved;
  enter(child, nodes_[node].place);
  enter(child + 1, triangles_.add());
  settle(child);
  settle(child + 1);
}

void BinTree::mend(std::uint32_t node) {
  const std::uint32_t child = nodes_[node].child;
  free(leave(child + 1));
  draw(node, leave(child));
}

// Returns the place in the list that it, or one of those below, was drawn at.
std::uint32_t BinTree::leave(std::uint32_t node) {
  Node& n = nodes_[node];
  if (n.state == State::Halved) {
    free(leave(n.child + 1));
    n.place = leave(n.child);
  } else {
    uncount(n);
  }
  n.state = State::Out;
  if (n.vertex != kNone) vertices_.detach(n.vertex, node);
  return n.place;
}

void BinTree::enter(std::uint32_t node, std::uint32_t place) {
  draw(node, place);
  if (nodes_[node].vertex != kNone) vertices_.attach(nodes_[node].vertex, node);
}

void BinTree::draw(std::uint32_t node, std::uint32_t place) {
  Node& n = nodes_[node];
  n.state = State::Whole;
  n.place = place;
  // Triangles of odd depth are wound counter-clockwise (vertex_index.h), and depths are even in
  // number.
  const bool turn = (n.levels & 1) == 0;
  triangles_.set(place, node, {n.apex, turn ? n.right : n.left, turn ? n.left : n.right});
  if (n.vertex != kNone) deltas_.add(vertices_.live(n.vertex).record.delta);
}

void BinTree::uncount(const Node& whole) {
  if (whole.vertex != kNone) deltas_.remove(vertices_.live(whole.vertex).record.delta);
}

void BinTree::free(std::uint32_t place) {
  nodes_[triangles_.remove(place)].place = place;
}

// Children stand in pairs behind four roots: left ones have even numbers.
VertexIndex BinTree::index_of_vertex(std::uint32_t node) const {
  if (node < kRoots) return kRootTriangles[node].middle;
  const Node& n = nodes_[node];
  const VertexIndex middle = vertices_.index(n.apex);  // of the parent, whose apex is a corner
  return node % 2 == 0 ? left_child(vertices_.index(n.right), middle)
                       : right_child(vertices_.index(n.left), middle);
}

bool BinTree::find_vertex(std::uint32_t node) {
  Node& n = nodes_[node];
  if (n.vertex != kNone) return true;
  n.vertex = vertices_.acquire(index_of_vertex(node),
                               middle_of(vertices_.post(n.left), vertices_.post(n.right)));
  if (n.vertex == kNone) return false;
  vertices_.attach(n.vertex, node);
  deltas_.add(vertices_.live(n.vertex).record.delta);
  return true;
}

bool BinTree::lasts(std::uint32_t vertex) const {
  const LiveVertex& v = vertices_.live(vertex);
  // "If v's bounding sphere overlaps the view volume and d_tau is not negative, d_c is
  // re-evaluated [...] when v is not completely within" [BaoPajarolaShafae2004, 4.4 and Figure 6]:
  // by the flags from before the rotation.
  const bool doubted = frame_->figure_6 && v.wanted() && !v.inside;
  return !doubted && alive(odometer_.now(), v.until);
}

void BinTree::evaluate(std::uint32_t vertex) {
  ++findings_.evaluated;
  LiveVertex& v = vertices_.live(vertex);
  frame_->evaluation(vertices_.ball(vertex), v);
  if (v.selected && !v.visible) ++findings_.culled;
}

void BinTree::expect(std::uint32_t vertex) {
  ends_.set(vertex, vertices_.live(vertex).until);
  expect_soon(vertex);
}

void BinTree::expect_soon(std::uint32_t vertex) {
  if (looks_ahead_) soon_.set(vertex, odometer_.before(vertices_.live(vertex).until, kFramesAhead));
}

// A page is named once, so it stays until it is there; the oldest go where too many wait.
void BinTree::look_ahead() {
  std::erase_if(pages_ahead_, [&](std::uint64_t page) { return ground_.pages().holds(page); });
  soon_.renew_ended(odometer_.now(), [this](std::uint32_t vertex) {
    look_below(vertex);
    return RangeEnds::kNever;
  });
  if (pages_ahead_.size() <= kMostAhead) return;
  pages_ahead_.erase(pages_ahead_.begin(), pages_ahead_.end() - kMostAhead);
}

void BinTree::look_below(std::uint32_t vertex) {
  for (const std::uint32_t node : vertices_.halves(vertex)) {
    if (node == kNone || nodes_[node].levels == 1 || nodes_[node].state != State::Whole) continue;
    const VertexIndex apex = vertices_.index(nodes_[node].apex);
    const VertexIndex middle = vertices_.index(vertex);
    for (const VertexIndex child : {left_child(apex, middle), right_child(apex, middle)}) {
      if (vertices_.has(child)) continue;
      const std::uint64_t page = RecordPages::page_of(child);
      if (!ground_.pages().holds(page) &&
          std::ranges::find(pages_ahead_, page) == pages_ahead_.end())
        pages_ahead_.push_back(page);
    }
  }
}

void BinTree::wait(std::uint32_t node) {
  if (nodes_[node].waits) return;
  nodes_[node].waits = true;
  waiting_.push_back(node);
}

std::uint32_t BinTree::children_of(std::uint32_t node) {
  const Node n = nodes_[node];
  if (n.child != 0) return n.child;
  const auto child = static_cast<std::uint32_t>(nodes_.size());
  const auto levels = static_cast<std::int8_t>(n.levels - 1);
  nodes_[node].child = child;
  nodes_.push_back({.apex = n.vertex, .left = n.left, .right = n.apex, .levels = levels});
  nodes_.push_back({.apex = n.vertex, .left = n.apex, .right = n.right, .levels = levels});
  return child;
}

void BinTree::expire() {
  vertices_.expire();
  for (std::uint32_t vertex = 0; vertex < vertices_.size(); ++vertex) ends_.set(vertex, {});
}

void BinTree::collect() {
  old_nodes_.swap(nodes_);
  nodes_.resize(kRoots);
  triangles_.clear();
  deltas_.clear();
  ends_.clear();
  soon_.clear();
  waiting_.clear();
  vertices_.begin_collection();
  for (std::uint32_t i = 0; i < kRoots; ++i) keep(i, i);
  vertices_.end_collection();
  old_nodes_.clear();
  if (2 * nodes_.size() <= capacity_) return;
  capacity_ *= 2;
  make_room();
}

void BinTree::keep(std::uint32_t from, std::uint32_t to) {
  const Node old = old_nodes_[from];
  Node& n = nodes_[to];
  n = old;
  for (std::uint32_t* slot : {&n.apex, &n.left, &n.right, &n.vertex}) *slot = vertices_.keep(*slot);
  n.child = 0;
  n.waits = false;
  if (n.vertex != kNone) expect(n.vertex);
  if (old.waits) wait(to);
  if (old.state == State::Whole) return enter(to, triangles_.add());
  if (n.vertex != kNone) vertices_.attach(n.vertex, to);
  const std::uint32_t child = children_of(to);
  keep(old.child, child);
  keep(old.child + 1, child + 1);
}

}  // namespace arete::lod::bintree
