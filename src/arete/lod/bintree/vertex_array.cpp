#include "arete/lod/bintree/vertex_array.h"

namespace arete::lod::bintree {

VertexArray::VertexArray(Ground& ground) : ground_(ground) {
  const Domain& domain = ground.domain();
  append(kCentre, domain.post_of(kCentre), ground.centre());
  for (VertexIndex v = kSouthWest; v <= kNorthWest; ++v)
    append(v, domain.post_of(v), ground.corner(v));
  for (Place& place : places_) place.live.rooted = true;
}

void VertexArray::reserve(std::size_t vertices) {
  drawn_.reserve(vertices);
  old_drawn_.reserve(vertices);
  places_.reserve(vertices);
  old_places_.reserve(vertices);
}

std::uint32_t VertexArray::append(VertexIndex index, Post post, const Record& record) {
  const auto slot = static_cast<std::uint32_t>(drawn_.size());
  drawn_.push_back({.post = post, .z = static_cast<float>(ground_.z_of(record))});
  places_.push_back({.live = {.record = record}, .index = index, .post = post});
  slots_.set(index, slot);
  return slot;
}

void VertexArray::begin_frame(OnMissing on_missing) {
  on_missing_ = on_missing;
  if (missing_.size() > 0) missing_.clear();
  missing_pages_.clear();
}

std::uint32_t VertexArray::acquire(VertexIndex index, Post post) {
  if (const std::uint32_t* known = slots_.find(index)) return *known;
  if (missing_.size() > 0 && missing_.find(index) != nullptr) return kNone;
  if (const Record* record = ground_.pages().find(index, on_missing_))
    return append(index, post, *record);
  missing_.set(index, 0);
  missing_pages_.push_back(RecordPages::page_of(index));
  return kNone;
}

bool VertexArray::root(std::uint32_t slot) {
  Place& place = places_[slot];
  // The apex of a triangle of the tree has its ancestors there.
  if (place.halves[0] != kNone && place.halves[1] != kNone) place.live.rooted = true;
  if (place.live.rooted) return true;
  const Parents parents = parents_of(places_[slot].post, ground_.domain());
  for (int i = 0; i < parents.count; ++i) {
    const Post post = parents.post[static_cast<std::size_t>(i)];
    const std::uint32_t at = acquire(ground_.domain().index_of(post), post);
    if (at == kNone || !root(at)) return false;
  }
  places_[slot].live.rooted = true;
  return true;
}

void VertexArray::attach(std::uint32_t slot, std::uint32_t triangle) {
  Halves& halves = places_[slot].halves;
  halves[halves[0] == kNone ? 0 : 1] = triangle;
}

void VertexArray::detach(std::uint32_t slot, std::uint32_t triangle) {
  Halves& halves = places_[slot].halves;
  halves[halves[0] == triangle ? 0 : 1] = kNone;
}

void VertexArray::expire() {
  for (Place& place : places_) place.live.until = {};
}

void VertexArray::begin_collection() {
  old_drawn_.swap(drawn_);
  old_places_.swap(places_);
  drawn_.clear();
  places_.clear();
  slots_.clear();
  ++key_;
  for (std::uint32_t slot = kCentreSlot; slot < kFirstCornerSlot + 4; ++slot) keep(slot);
}

std::uint32_t VertexArray::keep(std::uint32_t slot) {
  if (slot == kNone) return kNone;
  const VertexIndex index = old_places_[slot].index;
  if (const std::uint32_t* known = slots_.find(index)) return *known;
  const auto kept = static_cast<std::uint32_t>(drawn_.size());
  drawn_.push_back(old_drawn_[slot]);
  places_.push_back(old_places_[slot]);
  // Ancestors of active vertices are in the tree and kept; those of others may not be.
  Place& place = places_.back();
  place.live.rooted = place.live.active();
  place.halves = {kNone, kNone};
  slots_.set(index, kept);
  return kept;
}

void VertexArray::end_collection() {
  old_drawn_.clear();
  old_places_.clear();
}

}  // namespace arete::lod::bintree
