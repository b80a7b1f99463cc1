#pragma once

#include <compare>
#include <cstdint>

namespace arete {

/// A DEM sample: column (east) and row (south). Integers, so shared corners agree exactly.
struct Post {
  std::int32_t col = 0, row = 0;
  friend bool operator==(const Post&, const Post&) = default;
};

/// Half-open rectangle of posts or cells: [col0, col1) x [row0, row1).
struct PostRect {
  std::int32_t col0 = 0, row0 = 0, col1 = 0, row1 = 0;
  bool empty() const { return col0 >= col1 || row0 >= row1; }
  friend bool operator==(const PostRect&, const PostRect&) = default;
};

}  // namespace arete
