#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "arete/core/post.h"

namespace arete::store {

/// Heights for posts without data: averages over square cells of posts, cells without data filled
/// from a pyramid of averages (push-pull), bilinear between cell centres. Sums are integers, so the
/// result does not depend on the order of adding. Memory: 20 bytes a cell, at most 4 M cells up to
/// 262,144 posts a side.
class FillGrid {
 public:
  FillGrid(int cols, int rows);

  int cell_posts() const { return cell_posts_; }  ///< posts a side: a power of two, 16 to 128

  struct Cell {
    std::int64_t sum = 0;
    std::int64_t count = 0;
  };
  /// Sets whole rows of cells. Thread contract: distinct rows at once.
  void set_rows(int first_row, std::span<const Cell> cells);
  /// Push and pull; set_rows must not be called after it.
  void finish();
  /// The filled count of a post. Requires: finish().
  std::int32_t at(Post post) const;

 private:
  int cols_, rows_, cell_posts_;
  std::vector<Cell> cells_;
  std::vector<double> filled_;
};

}  // namespace arete::store
