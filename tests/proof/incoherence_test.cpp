#include "arete/proof/incoherence.h"

#include <gtest/gtest.h>

namespace arete::proof {
namespace {

/// Two triangles of a unit square in the list's own arrays, split along one of the diagonals.
DrawList square(bool main_diagonal) {
  DrawList list;
  for (const Post post : {Post{0, 0}, Post{1, 0}, Post{0, 1}, Post{1, 1}}) {
    Vertex vertex;
    vertex.post = post;
    list.vertices.push_back(vertex);
  }
  list.indices = main_diagonal ? std::vector<std::uint32_t>{0, 2, 3, 0, 3, 1}
                               : std::vector<std::uint32_t>{0, 2, 1, 1, 2, 3};
  DrawBatch batch;
  batch.index_count = 6;
  list.batches.push_back(batch);
  return list;
}

struct NoBlocks : BlockSource {
  std::span<const Vertex> vertices(BlockKey) const override { return {}; }
  std::span<const std::uint32_t> indices(BlockKey) const override { return {}; }
};

TEST(Incoherence, CountsChangedTriangles) {
  Incoherence same, flipped;
  for (const bool turn : {false, true, false}) {
    same.add(square(true), NoBlocks{});
    flipped.add(square(turn), NoBlocks{});
  }
  EXPECT_DOUBLE_EQ(same.percent(), 0);
  EXPECT_DOUBLE_EQ(flipped.percent(), 200);  // all of the old and all of the new
}

}  // namespace
}  // namespace arete::proof
