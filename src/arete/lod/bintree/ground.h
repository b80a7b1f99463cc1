#pragma once

#include <array>

#include "arete/lod/bintree/ancestry.h"
#include "arete/lod/bintree/criterion.h"
#include "arete/lod/bintree/index_map.h"
#include "arete/lod/bintree/record_pages.h"

namespace arete::lod::bintree {

/// The records of a terrain with their places in the world: what both methods refine.
class Ground {
 public:
  /// Throws: as RecordPages; Corrupt when the corners cannot be read.
  Ground(const store::Terrain& terrain, const RecordPages::Options& options);

  RecordPages& pages() { return pages_; }
  const RecordPages& pages() const { return pages_; }
  const Domain& domain() const { return pages_.domain(); }
  /// False for a terrain without a drawable cell: nothing is drawn then.
  bool has_cells() const { return cells_ > 0; }
  std::uint64_t full_triangles() const { return 2 * cells_; }
  const Record& corner(VertexIndex vertex) const { return corners_[vertex - kSouthWest]; }
  const Record& centre() const { return centre_; }

  /// Distance from the eye to the box of the domain, metres.
  double nearest_m(glm::dvec3 eye) const;

  const Affine2& world_from_post() const { return world_from_post_; }
  double offset_m() const { return offset_m_; }
  double quantum_m() const { return quantum_m_; }
  double z_of(const Record& record) const { return offset_m_ + quantum_m_ * record.count; }
  Ball ball(Post post, const Record& record) const {
    return {glm::dvec3(world_from_post_.apply(post.col, post.row), z_of(record)),
            value(record.delta), value(record.radius)};
  }

 private:
  Affine2 world_from_post_;
  double offset_m_, quantum_m_;
  std::uint64_t cells_;
  double z_min_, z_max_;
  RecordPages pages_;
  Record centre_;
  std::array<Record, 4> corners_;
};

/// Which vertices are there with all their ancestors, in one frame. The active vertices among them
/// form a conforming surface whatever is missing.
class Presence {
 public:
  explicit Presence(Ground& ground) : ground_(ground) {}
  void begin_frame(OnMissing on_missing) {
    on_missing_ = on_missing;
    whole_.clear();
  }
  bool whole(VertexIndex index, Post post);

 private:
  Ground& ground_;
  OnMissing on_missing_ = OnMissing::Wait;
  IndexMap whole_;
};

}  // namespace arete::lod::bintree
