#include "arete/lod/bintree/groups.h"

#include <algorithm>
#include <cassert>

#include "arete/lod/bintree/record_pages.h"

namespace arete::lod::bintree {
namespace {

// A page holds two subtrees of four generations, brothers: half of what descends from a vertex five
// generations above the page's own.
constexpr int kPageGenerations = 5;
// Black pages of the coarser level (squares of 4 cells) reach this far out of the block: half the
// diagonal of the diamond below that vertex, 16 squares of 4 cells.
constexpr int kOverhang = 64;
// Beyond them, what their nesting asks for: squares of 4 cells, then of 2.
constexpr int kMargin = kOverhang + 4;

int lattice_posts(int posts, int log2_spacing) {
  return ((std::max(posts - 1, 0) + (1 << log2_spacing) - 1) >> log2_spacing) + 1;
}

}  // namespace

Groups::Groups(int cols, int rows, int log2_block)
    : domain_(Domain::over(cols, rows)), log2_block_(log2_block) {
  assert(log2_block >= kMinLog2Block);
  const auto blocks = [&](int posts, int group) {
    const int reached = lattice_posts(posts, log2_spacing(group)) - 1 + kMargin;
    return std::min(reached >> log2_block_, (lattice_cells(group) >> log2_block_) - 1) + 1;
  };
  int group = 0;
  for (; lattice_cells(group) > 1 << log2_block_; ++group)
    groups_.push_back({blocks(cols, group), blocks(rows, group)});
  groups_.push_back({1, 1});
}

int Groups::first_unit(int group) const {
  int unit = 0;
  for (int g = 0; g < group; ++g) unit += blocks_x(g) * blocks_y(g);
  return unit;
}

BlockId Groups::block_of(int unit) const {
  int group = 0;
  while (unit >= first_unit(group + 1)) ++group;
  const int i = unit - first_unit(group);
  return {group, i % blocks_x(group), i / blocks_x(group)};
}

int Groups::unit_of(const BlockId& block) const {
  return first_unit(block.group) + block.y * blocks_x(block.group) + block.x;
}

int Groups::levels(int group) const {
  return is_last(group) ? domain_.log2_cells() - log2_spacing(group) : kLevels;
}

int Groups::block_cells(int group) const {
  return is_last(group) ? lattice_cells(group) : 1 << log2_block_;
}

PostRect Groups::region(const BlockId& block) const {
  const int cells = block_cells(block.group);
  const PostRect whole{0, 0, lattice_cells(block.group) + 1, lattice_cells(block.group) + 1};
  if (is_last(block.group)) return whole;
  const int x = block.x * cells;
  const int y = block.y * cells;
  return {std::max(x - kMargin, 0), std::max(y - kMargin, 0),
          std::min(x + cells + kMargin, whole.col1), std::min(y + cells + kMargin, whole.row1)};
}

std::vector<std::uint64_t> Groups::pages(const BlockId& block) const {
  std::vector<std::uint64_t> pages;
  if (is_last(block.group)) {
    const int coarsest = log2_spacing(block.group);
    const std::uint64_t end = Domain(domain_.log2_cells() - coarsest).index_end();
    for (std::uint64_t page = 0; page << kLog2PageRecords < end; ++page) pages.push_back(page);
    return pages;
  }
  for (int level = kLevels - 1; level >= 0; --level) {
    const auto [first, end] = white_pages(block, level);
    for (std::uint64_t page = first; page < end; ++page) pages.push_back(page);
    append_black_pages(block, level, pages);
  }
  std::ranges::sort(pages);
  return pages;
}

std::pair<std::uint64_t, std::uint64_t> Groups::coarser_white_pages(const BlockId& block) const {
  return white_pages(block, kLevels - 1);
}

// The block is a square of the domain: its white vertices are one subtree.
std::pair<std::uint64_t, std::uint64_t> Groups::white_pages(const BlockId& block, int level) const {
  const int s = log2_spacing(block.group);
  const int cells = 1 << (log2_block_ + s);
  const VertexIndex root =
      domain_.index_of({block.x * cells + cells / 2, block.y * cells + cells / 2});
  const int generations = log2_block_ - 1 - level;
  return {(root << (2 * generations)) >> kLog2PageRecords,
          ((root + 1) << (2 * generations)) >> kLog2PageRecords};
}

// The vertices five generations up lie on the sides of squares of `square` cells. One on the
// border of two blocks belongs to the eastern or southern one, on the border of the domain to the
// only one there is.
void Groups::append_black_pages(const BlockId& block, int level,
                                std::vector<std::uint64_t>& out) const {
  const int s = log2_spacing(block.group);
  const int half = 1 << (level + s + kPageGenerations);
  const int cells = 1 << (log2_block_ + s);
  const Post first{block.x * cells, block.y * cells};
  const auto end = [&](int from) {
    return from + cells == domain_.side() ? from + cells : from + cells - 1;
  };
  for (int row = first.row; row <= end(first.row); row += half) {
    const int begin = first.col + (row / half % 2 == 0 ? half : 0);
    for (int col = begin; col <= end(first.col); col += 2 * half) {
      const VertexIndex ancestor = domain_.index_of({col, row});
      const std::uint64_t page = (ancestor << (2 * kPageGenerations)) >> kLog2PageRecords;
      out.push_back(page);
      out.push_back(page + 1);
    }
  }
}

}  // namespace arete::lod::bintree
