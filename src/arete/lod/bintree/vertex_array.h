#pragma once

#include <span>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/lod/bintree/ground.h"
#include "arete/lod/bintree/live_range.h"

namespace arete::lod::bintree {

/// The vertices that the bin-tree array has met, in the order it met them: appended only, so that a
/// renderer keeps them and frames send indices alone [BaoPajarolaShafae2004, 4.5]. Deviation: one
/// place a vertex instead of one a node, so a status is found once for both of its triangles.
class VertexArray {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  using Halves = std::array<std::uint32_t, 2>;
  /// The first five.
  static constexpr std::uint32_t kCentreSlot = 0, kFirstCornerSlot = 1;

  explicit VertexArray(Ground& ground);
  /// Takes the memory for so many vertices, and for as many kept by a collection.
  void reserve(std::size_t vertices);

  /// Vertices that could not be found are looked for again.
  void begin_frame(OnMissing on_missing);
  /// The vertex's place; kNone when its record is not there, and then for all of the frame.
  std::uint32_t acquire(VertexIndex index, Post post);
  bool has(VertexIndex index) const { return slots_.find(index) != nullptr; }
  /// True when all ancestors have places too: what an active vertex needs, whatever is missing.
  bool root(std::uint32_t slot);

  /// Pages of the vertices that could not be found in this frame.
  std::span<const std::uint64_t> missing_pages() const { return missing_pages_; }

  LiveVertex& live(std::uint32_t slot) { return places_[slot].live; }
  const LiveVertex& live(std::uint32_t slot) const { return places_[slot].live; }
  VertexIndex index(std::uint32_t slot) const { return places_[slot].index; }
  /// The triangles of the tree that the vertex halves or may, by the tree's numbers; kNone = none.
  const Halves& halves(std::uint32_t slot) const { return places_[slot].halves; }
  bool is_attached(std::uint32_t slot) const {
    return halves(slot)[0] != kNone || halves(slot)[1] != kNone;
  }
  /// Requires: one of them is none.
  void attach(std::uint32_t slot, std::uint32_t triangle);
  /// Requires: attached.
  void detach(std::uint32_t slot, std::uint32_t triangle);
  Post post(std::uint32_t slot) const { return places_[slot].post; }
  Ball ball(std::uint32_t slot) const {
    return ground_.ball(places_[slot].post, places_[slot].live.record);
  }

  /// The drawn vertices; they hold until collect().
  std::span<const Vertex> drawn() const { return drawn_; }
  std::size_t size() const { return drawn_.size(); }
  BlockKey key() const { return key_; }
  /// Ends every live range.
  void expire();

  /// Begins a copy that keeps what is kept, in that order, under a new key; nothing is halved by
  /// it.
  void begin_collection();
  std::uint32_t keep(std::uint32_t slot);
  void end_collection();

 private:
  /// All that a frame asks about a vertex, in one line of the processor's cache.
  struct alignas(64) Place {
    LiveVertex live;
    Halves halves{kNone, kNone};
    VertexIndex index = 0;
    Post post;
  };
  static_assert(sizeof(Place) == 64);
  std::uint32_t append(VertexIndex index, Post post, const Record& record);

  Ground& ground_;
  OnMissing on_missing_ = OnMissing::Wait;
  std::vector<Vertex> drawn_, old_drawn_;
  std::vector<Place> places_, old_places_;
  IndexMap slots_, missing_;
  std::vector<std::uint64_t> missing_pages_;
  BlockKey key_ = 1;
};

}  // namespace arete::lod::bintree
