#include <gtest/gtest.h>

#include "arete/mesh/surface.h"

namespace arete::mesh {
namespace {

class OneBlock : public BlockSource {
 public:
  std::span<const Vertex> vertices(BlockKey) const override { return vertices_; }
  std::span<const std::uint32_t> indices(BlockKey) const override { return indices_; }
  std::vector<Vertex> vertices_;
  std::vector<std::uint32_t> indices_;
};

Vertex vertex(Post post, float z) {
  Vertex v;
  v.post = post;
  v.z = z;
  return v;
}

TEST(Flatten, MorphsHeightAndPlan) {
  DrawList list;
  Vertex v = vertex({4, 5}, 100);
  v.dz = {8, 4, 2};
  v.slot = {1, 2, 200, 255};
  v.dcol = 3;
  v.drow = -2;
  list.vertices = {v, vertex({4, 6}, 1), vertex({5, 6}, 2)};
  list.indices = {0, 1, 2};
  DrawBatch batch;
  batch.index_count = 3;
  batch.factor[1] = 0.5F;
  batch.factor[2] = 0.25F;
  list.batches = {batch};
  Surface s;
  flatten(list, OneBlock{}, s);
  ASSERT_EQ(s.vertices.size(), 3U);
  EXPECT_EQ(s.vertices[0].post, (Post{4, 5}));
  EXPECT_EQ(s.vertices[0].z, 105);
  EXPECT_EQ(s.vertices[0].dcol, 1.5F);
  EXPECT_EQ(s.vertices[0].drow, -1.0F);
}

TEST(Flatten, ExpandsStripsWithParityAndDropsTurns) {
  // Two rows of two cells in one strip, with a repeated index where it turns.
  OneBlock block;
  for (int r = 0; r < 2; ++r) {
    for (int c = 0; c < 3; ++c) block.vertices_.push_back(vertex({c, r}, 0));
  }
  block.indices_ = {0, 3, 1, 4, 2, 5};
  DrawList list;
  DrawBatch batch;
  batch.vertices = batch.indices = 7;
  batch.index_count = 6;
  batch.topology = Topology::Strip;
  list.batches = {batch};
  Surface s;
  flatten(list, block, s);
  EXPECT_EQ(s.triangles(), 4U);
  const Heightfield dem(3, 2);
  EXPECT_EQ(check_surface(s, dem, nullptr).cracks(), 0U);

  block.indices_ = {0, 0, 3, 1, 1, 4, 2, 2, 5};
  list.batches[0].index_count = 9;
  flatten(list, block, s);
  EXPECT_LT(s.triangles(), 7U);
}

TEST(Flatten, KeepsBatchesApartAndLeavesUnusedVerticesOut) {
  OneBlock block;
  for (int c = 0; c < 3; ++c) {
    block.vertices_.push_back(vertex({c, 0}, 0));
    block.vertices_.push_back(vertex({c, 1}, 0));
  }
  block.indices_ = {0, 1, 2, 2, 1, 3};
  DrawList list;
  DrawBatch batch;
  batch.vertices = batch.indices = 7;
  batch.index_count = 3;
  list.batches = {batch, batch};
  list.batches[1].first_index = 3;
  Surface s;
  flatten(list, block, s);
  EXPECT_EQ(s.triangles(), 2U);
  EXPECT_EQ(s.vertices.size(), 6U);
}

}  // namespace
}  // namespace arete::mesh
