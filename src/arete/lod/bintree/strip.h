#pragma once

#include <algorithm>
#include <bit>
#include <cassert>

#include "arete/core/draw_list.h"
#include "arete/lod/bintree/walk.h"

namespace arete::lod::bintree {

/// Writes one strip into a list while a Walk visits: a vertex is added unless it is one of the last
/// two; where the parity does not turn, a repeated vertex does [LindstromPascucci2002].
class Strip {
 public:
  /// What the list's arrays hold is overwritten, for clearing and growing them costs time.
  explicit Strip(DrawList& out) : out_(out), next_(out.indices.data()) { make_room(); }
  /// Cuts the arrays to what was written. Requires: the walk is over.
  void finish() {
    out_.indices.resize(index_count());
    out_.vertices.resize(vertex_count_);
  }

  void begin(Corner& first) {
    first.slot = vertex_count_++;
    write_vertex(first.slot, first);
    older_ = newer_ = {first.post, first.slot};
    next_ = std::fill_n(next_, 3, first.slot);  // the third turns the winding to ours
  }
  void halving(Corner&, const Ball&, const Corner&, const Corner&) {
    if (vertex_count_ > last_vertex_ || next_ > last_index_) [[unlikely]]
      make_room();
  }
  void halved(Corner& apex, int levels) { append(apex, levels); }
  void whole(Corner& apex, const Corner&, const Corner&, int levels) { append(apex, levels); }
  void root_done(Corner& right) {
    if (++roots_ < 4) {
      append(right, 0);
    } else {
      *next_++ = right.slot;
    }
  }

 private:
  /// A vertex in the strip.
  struct Laid {
    Post post;
    std::uint32_t slot = 0;
    bool is_at(Post other) const {
      return std::bit_cast<std::uint64_t>(post) == std::bit_cast<std::uint64_t>(other);
    }
  };
  static constexpr Vertex kBlank{};
  /// Between two calls of halving() every level above adds at most two vertices, and each root one
  /// or two; an addition writes two indices at most.
  static constexpr std::size_t kMostAdded = 128;
  static_assert(kMostAdded >= 2 * (2 * Domain::kMaxLog2Cells) + 4 * 2 + 3);

  // Which vertices repeat is guessed well; where the strip turns and whether a vertex has a slot is
  // not, so those are computed without branches, and what is written in vain is overwritten.
  void append(Corner& v, int levels) {
    const Laid older = older_;
    const Laid newer = newer_;
    if (newer.is_at(v.post) || older.is_at(v.post)) return;
    const unsigned parity = static_cast<unsigned>(levels) & 1U;
    const auto turns = static_cast<unsigned>(parity == parity_);
    const auto fresh = static_cast<unsigned>(v.slot == Corner::kNone);
    const std::uint32_t count = vertex_count_;
    const std::uint32_t slot = fresh != 0 ? count : v.slot;
    std::uint32_t* next = next_;
    next[0] = older.slot;  // a turn: the older one stays
    next[turns] = slot;
    next_ = next + turns + 1;
    write_vertex(count, v);
    vertex_count_ = count + fresh;
    v.slot = slot;
    older_.post = turns != 0 ? older.post : newer.post;
    older_.slot = turns != 0 ? older.slot : newer.slot;
    newer_ = {v.post, slot};
    parity_ = parity;
  }

  void write_vertex(std::uint32_t slot, const Corner& v) {
    assert(slot < out_.vertices.size() && index_count() <= out_.indices.size());
    Vertex& at = vertices_[slot];
    at = kBlank;
    at.post = v.post;
    at.z = v.z;
  }

  std::size_t index_count() const { return static_cast<std::size_t>(next_ - out_.indices.data()); }

  void make_room() {
    const std::size_t used = index_count();
    out_.vertices.resize(out_.vertices.size() + out_.vertices.size() / 8 + 8 * kMostAdded);
    out_.indices.resize(2 * out_.vertices.size());
    vertices_ = out_.vertices.data();
    next_ = out_.indices.data() + used;
    last_vertex_ = static_cast<std::uint32_t>(out_.vertices.size() - kMostAdded);
    last_index_ = out_.indices.data() + out_.indices.size() - 2 * kMostAdded;
  }

  DrawList& out_;
  Vertex* vertices_ = nullptr;
  std::uint32_t *next_, *last_index_ = nullptr;  ///< room for kMostAdded up to the last
  std::uint32_t vertex_count_ = 0, last_vertex_ = 0;
  Laid older_, newer_;
  unsigned parity_ = 1;
  int roots_ = 0;
};

/// A strip whose vertices morph: from where `inner`, what the walk goes by, makes one active to
/// where `outer`, the whole tolerance, does, it moves from the edge that it halves to its place.
class MorphingStrip : public Strip {
 public:
  MorphingStrip(DrawList& out, const Criterion& outer, const Criterion& inner)
      : Strip(out), outer_(outer), inner_(inner) {}

  // z' = ((d_max - d) z + (d - d_min) (z_l' + z_r') / 2) / (d_max - d_min), d = |P - v|^2
  // [LindstromPascucci2002; METHODS 3.2].
  void halving(Corner& corner, const Ball& ball, const Corner& l, const Corner& r) {
    Strip::halving(corner, ball, l, r);
    const glm::dvec3 to = ball.centre - inner_.eye();
    const double d = glm::dot(to, to);  // below `none`: the vertex is active
    const double full = outer_.reach(ball) * outer_.reach(ball);
    if (!(d > full)) return;
    const double none = inner_.reach(ball) * inner_.reach(ball);
    const double share = (d - full) / (none - full);
    const double flat = (static_cast<double>(l.z) + static_cast<double>(r.z)) / 2;
    corner.z = static_cast<float>(ball.centre.z + share * (flat - ball.centre.z));
  }

 private:
  const Criterion &outer_, &inner_;
};

}  // namespace arete::lod::bintree
