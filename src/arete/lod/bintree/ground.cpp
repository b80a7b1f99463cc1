#include "arete/lod/bintree/ground.h"

#include <limits>

#include "arete/core/error.h"

namespace arete::lod::bintree {
namespace {

Record must_find(RecordPages& pages, VertexIndex vertex, const std::string& terrain) {
  const Record* record = pages.find(vertex, OnMissing::Wait);
  if (record == nullptr)
    throw Error(ErrorCode::Corrupt,
                terrain + ": page 1 of its bin-tree is damaged: build it again with --force");
  return *record;
}

}  // namespace

Ground::Ground(const store::Terrain& terrain, const RecordPages::Options& options)
    : world_from_post_(terrain.manifest().georef.world_from_post),
      offset_m_(terrain.manifest().offset_m),
      quantum_m_(terrain.manifest().quantum_m),
      cells_(terrain.manifest().drawable_cells),
      z_min_(terrain.manifest().z_min),
      z_max_(terrain.manifest().z_max),
      pages_(terrain, options) {
  if (!has_cells()) return;
  pages_.begin_frame();
  centre_ = must_find(pages_, kCentre, terrain.name());
  for (VertexIndex v = kSouthWest; v <= kNorthWest; ++v)
    corners_[v - kSouthWest] = must_find(pages_, v, terrain.name());
}

double Ground::nearest_m(glm::dvec3 eye) const {
  const double side = domain().side();
  glm::dvec2 lo(std::numeric_limits<double>::infinity());
  glm::dvec2 hi = -lo;
  for (const glm::dvec2 corner : {glm::dvec2(0, 0), {side, 0}, {0, side}, {side, side}}) {
    lo = glm::min(lo, world_from_post_.apply(corner.x, corner.y));
    hi = glm::max(hi, world_from_post_.apply(corner.x, corner.y));
  }
  const glm::dvec3 inside = glm::clamp(eye, glm::dvec3(lo, z_min_), glm::dvec3(hi, z_max_));
  return glm::length(eye - inside);
}

bool Presence::whole(VertexIndex index, Post post) {
  if (const std::uint32_t* known = whole_.find(index)) return *known != 0;
  bool whole = ground_.pages().find(index, on_missing_) != nullptr;
  const Parents parents = parents_of(post, ground_.domain());
  for (int i = 0; whole && i < parents.count; ++i) {
    const Post p = parents.post[static_cast<std::size_t>(i)];
    whole = this->whole(ground_.domain().index_of(p), p);
  }
  whole_.set(index, whole ? 1 : 0);
  return whole;
}

}  // namespace arete::lod::bintree
