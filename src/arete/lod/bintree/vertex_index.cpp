#include "arete/lod/bintree/vertex_index.h"

#include <algorithm>
#include <bit>

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::lod::bintree {
namespace {

// Steps from a parent to its four children, in the order of their digits, in units of a quarter of
// the parent's square: SW, SE, NE, NW for white, N, E, S, W for black vertices.
constexpr std::array<Post, 4> kWhiteSteps{{{-1, 1}, {1, 1}, {1, -1}, {-1, -1}}};
constexpr std::array<Post, 4> kBlackSteps{{{0, -1}, {1, 0}, {0, 1}, {-1, 0}}};

int generation_of(VertexIndex index) {
  return (static_cast<int>(std::bit_width(index)) - 2) / 2;
}

bool is_root(VertexIndex index) {
  return index >= kCentre && index <= kNorth;
}

bool is_white(VertexIndex index) {
  return index >> (2 * generation_of(index)) == kCentre;
}

VertexIndex root_of_black(Post post, int side) {
  if (post.col == 0) return kWest;
  if (post.row == side) return kSouth;
  return post.col == side ? kEast : kNorth;
}

// Digits from the finest generation up: every other coordinate bit says which quarter it is.
VertexIndex white_index(Post post, int log2_square, int k) {
  VertexIndex index = kCentre;
  for (int bit = k - 1; bit >= log2_square; --bit) {
    const int east = (post.col >> bit) & 1;
    const int south = (post.row >> bit) & 1;
    const int digit = south != 0 ? east : 3 - east;
    index = 4 * index + static_cast<VertexIndex>(digit);
  }
  return index;
}

// A black vertex lies `half` beside its parent, along the axis in which it is an odd multiple of
// half; of the two posts there one is black, the other white.
VertexIndex black_index(Post post, int half, int side) {
  VertexIndex digits = 0;
  int shift = 0;
  for (; 2 * half < side; half *= 2, shift += 2) {
    const bool along_row = ((post.col / half) & 1) != 0;
    int& odd = along_row ? post.col : post.row;
    const int even = along_row ? post.row : post.col;
    const bool forward = (((odd - half) / half / 2 + even / half / 2) & 1) != 0;
    odd += forward ? -half : half;
    const VertexIndex digit = along_row ? (forward ? 1U : 3U) : (forward ? 2U : 0U);
    digits |= digit << shift;
  }
  return (root_of_black(post, side) << shift) | digits;
}

}  // namespace

Domain Domain::over(int cols, int rows) {
  if (!fits(cols, rows))
    throw Error(ErrorCode::Limit,
                fmt::format("{} x {} posts: at most {} a side: use another method", cols, rows,
                            (1 << kMaxLog2Cells) + 1));
  const auto cells = static_cast<unsigned>(std::max({cols - 1, rows - 1, 2}));
  return Domain(static_cast<int>(std::bit_width(cells - 1)));
}

bool Domain::fits(int cols, int rows) {
  return std::max(cols, rows) - 1 <= 1 << kMaxLog2Cells;
}

VertexIndex Domain::index_of(Post post) const {
  assert(post.col >= 0 && post.row >= 0 && post.col <= side() && post.row <= side());
  const bool east = post.col == side();
  const bool south = post.row == side();
  if (post.col % side() == 0 && post.row % side() == 0) {
    if (south) return east ? kSouthEast : kSouthWest;
    return east ? kNorthEast : kNorthWest;
  }
  // side() stands for 0: it has no bit below those of the square.
  const int col_zeros = std::countr_zero(static_cast<unsigned>(post.col | side()));
  const int row_zeros = std::countr_zero(static_cast<unsigned>(post.row | side()));
  const int log2_half = std::min(col_zeros, row_zeros);
  if (col_zeros == row_zeros) return white_index(post, log2_half + 1, k_);
  return black_index(post, 1 << log2_half, side());
}

Post Domain::post_of(VertexIndex index) const {
  assert(is_vertex(index));
  if (index >= kSouthWest && index <= kNorthWest) {
    const Post& step = kWhiteSteps[index - kSouthWest];
    return {(step.col + 1) / 2 * side(), (step.row + 1) / 2 * side()};
  }
  const int generation = generation_of(index);
  const auto& steps = is_white(index) ? kWhiteSteps : kBlackSteps;
  Post post{side() / 2, side() / 2};
  switch (index >> (2 * generation)) {
    case kWest:
      post.col = 0;
      break;
    case kSouth:
      post.row = side();
      break;
    case kEast:
      post.col = side();
      break;
    case kNorth:
      post.row = 0;
      break;
    default:
      break;
  }
  for (int g = 1; g <= generation; ++g) {
    const Post& step = steps[(index >> (2 * (generation - g))) & 3U];
    const int quarter = side() >> (g + 1);
    post.col += step.col * quarter;
    post.row += step.row * quarter;
  }
  return post;
}

bool Domain::is_vertex(VertexIndex index) const {
  if (index >= kSouthWest && index <= kNorthWest) return true;
  if (index < kCentre || index >= index_end()) return false;
  return is_root(index >> (2 * generation_of(index)));
}

int Domain::depth_of(VertexIndex index) {
  if (index >= kSouthWest && index <= kNorthWest) return -1;
  return 2 * generation_of(index) + (is_white(index) ? 0 : 1);
}

}  // namespace arete::lod::bintree
