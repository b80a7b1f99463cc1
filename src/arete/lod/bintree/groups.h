#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "arete/core/post.h"
#include "arete/lod/bintree/vertex_index.h"

namespace arete::lod::bintree {

/// One block of a group: what one unit of the segment makes.
struct BlockId {
  int group = 0, x = 0, y = 0;
};

/// How the records of a terrain are cut into units of bounded memory.
///
/// A group holds the vertices of some successive levels (a vertex at multiples of 2^l and no more
/// has level l; it halves squares of 2^(l+1) cells). Its lattice are the posts at multiples of
/// 2^log2_spacing. All groups but the last hold two levels and are cut into blocks of 2^log2_block
/// lattice cells a side; the last holds all the levels that are left, in one block. Units are the
/// blocks group by group, finest first; those that lie outside the grid are left out.
class Groups {
 public:
  static constexpr int kLog2Block = 10;
  static constexpr int kMinLog2Block = 8;  ///< the height pyramid has the last group's lattice then
  Groups(int cols, int rows, int log2_block = kLog2Block);

  const Domain& domain() const { return domain_; }
  int count() const { return static_cast<int>(groups_.size()); }
  int units() const { return first_unit(count()); }
  int first_unit(int group) const;
  BlockId block_of(int unit) const;
  int unit_of(const BlockId& block) const;
  bool is_last(int group) const { return group + 1 == count(); }

  int log2_spacing(int group) const { return kLevels * group; }
  int levels(int group) const;
  /// Lattice cells of a group along the whole domain.
  int lattice_cells(int group) const { return domain_.side() >> log2_spacing(group); }
  int blocks_x(int group) const { return at(group).x; }
  int blocks_y(int group) const { return at(group).y; }
  int block_cells(int group) const;
  /// The lattice posts that a block's records depend on: the block itself, the black pages that
  /// reach out of it to the west and north, and what their nesting asks for.
  PostRect region(const BlockId& block) const;
  /// The pages whose records the block makes, ascending.
  std::vector<std::uint64_t> pages(const BlockId& block) const;
  /// Of the white pages at the block's coarser level: [first, end).
  std::pair<std::uint64_t, std::uint64_t> coarser_white_pages(const BlockId& block) const;

 private:
  static constexpr int kLevels = 2;
  struct Blocks {
    int x = 1, y = 1;
  };
  const Blocks& at(int group) const { return groups_[static_cast<std::size_t>(group)]; }
  std::pair<std::uint64_t, std::uint64_t> white_pages(const BlockId& block, int level) const;
  void append_black_pages(const BlockId& block, int level, std::vector<std::uint64_t>& out) const;

  Domain domain_;
  int log2_block_;
  std::vector<Blocks> groups_;
};

}  // namespace arete::lod::bintree
