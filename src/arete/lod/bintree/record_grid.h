#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "arete/core/georef.h"
#include "arete/core/post.h"
#include "arete/lod/bintree/groups.h"
#include "arete/lod/bintree/record.h"
#include "arete/store/terrain.h"

namespace arete::lod::bintree {

/// The records of one block while they are made: one for each lattice post of its region.
class RecordGrid {
 public:
  RecordGrid(const store::Terrain& terrain, const Groups& groups, const BlockId& block);

  const BlockId& block() const { return block_; }
  const PostRect& region() const { return region_; }  ///< lattice posts
  int log2_spacing() const { return log2_spacing_; }
  int levels() const { return levels_; }
  int lattice_cells() const { return cells_; }  ///< along the domain
  bool holds(Post p) const {
    return p.col >= region_.col0 && p.col < region_.col1 && p.row >= region_.row0 &&
           p.row < region_.row1;
  }
  /// Place of a post among those of the region, row-major.
  std::size_t index(Post lattice) const {
    return static_cast<std::size_t>(lattice.row - region_.row0) * width_ +
           static_cast<std::size_t>(lattice.col - region_.col0);
  }
  std::size_t size() const { return records_.size(); }
  std::int32_t count(Post lattice) const { return records_[index(lattice)].count; }

  /// Level 0 only: whether the post belongs to a drawable cell.
  void set_counted(Post lattice) { records_[index(lattice)].radius = 0; }
  /// The white vertex in the middle of a lattice cell, named by its NW post, of the next finer
  /// group.
  void set_finer(Post cell, const Record& record);
  /// Makes the codes, level by level from the finest: `own` are the vertices' own deltas in lattice
  /// counts, 0 where none of their triangles can be drawn wrongly; `slack_m` is added to the
  /// others.
  void nest(std::span<const double> own, double slack_m);
  /// The record, zero for a vertex without a drawable post below it; after nest().
  const Record& operator[](Post lattice) const { return records_[index(lattice)]; }
  /// Raises the largest delta of each depth by those of the region; after nest().
  void raise_maxima(std::span<Code> delta_max_of_depth) const;

 private:
  struct Step;
  std::array<Step, 4> steps(std::span<const Post> offsets, double unit) const;
  Code nest_black(int half);
  Code nest_white(int half);
  void finish();
  const Record* white_child(Post p, Post direction, int half) const;

  BlockId block_;
  PostRect region_;
  int log2_spacing_, levels_, cells_;
  std::size_t width_;
  double quantum_m_;
  Affine2 world_from_post_;
  std::vector<Record> records_;
  std::vector<Code> maxima_;   ///< white and black of each level, finest first
  std::vector<Record> finer_;  ///< (width - 1) a row; empty in the finest group
};

}  // namespace arete::lod::bintree
