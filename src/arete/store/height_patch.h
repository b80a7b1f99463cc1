#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "arete/core/post.h"
#include "arete/store/pyramid_shape.h"
#include "arete/store/terrain.h"

namespace arete::store {

/// The count of a post that lies in no stored tile; no real count takes this value.
inline constexpr std::int32_t kAbsent = std::numeric_limits<std::int32_t>::min();

/// Gives a tile, or null when it is not stored. The tile holds until the thread's next call.
using TileReader = std::function<const HeightTile*(TileId)>;

/// What a patch holds for posts beyond the grid that tiles on its border repeat.
enum class BeyondGrid { Repeat, Drop };

/// A rectangle of posts of one level, gathered from tiles. Keeps its memory from load to load.
class HeightPatch {
 public:
  /// Posts in no stored tile, outside the pyramid, or (Drop) beyond the grid are kAbsent and
  /// invalid. A border post that any stored tile holds is found. Throws: what `read` throws.
  void load(const PyramidShape& shape, int level, const PostRect& rect, BeyondGrid beyond,
            const TileReader& read);
  const PostRect& rect() const { return rect_; }
  /// Counts and validity of row `row` from column `col` on, both in posts of the level.
  const std::int32_t* counts(int row, int col) const { return counts_.data() + index(row, col); }
  const std::uint8_t* valid(int row, int col) const { return valid_.data() + index(row, col); }

  /// Bytes that a patch of this size needs.
  static std::size_t bytes(int cols, int rows) {
    return static_cast<std::size_t>(cols) * static_cast<std::size_t>(rows) *
           (sizeof(std::int32_t) + 1);
  }

 private:
  std::size_t index(int row, int col) const {
    return static_cast<std::size_t>(row - rect_.row0) *
               static_cast<std::size_t>(rect_.col1 - rect_.col0) +
           static_cast<std::size_t>(col - rect_.col0);
  }
  void copy(const HeightTile& tile, TileId id, const PostRect& bounds);

  PostRect rect_;
  std::vector<std::int32_t> counts_;
  std::vector<std::uint8_t> valid_;
};

}  // namespace arete::store
