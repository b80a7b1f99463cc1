#include <cmath>

#include "render/gl_test.h"
#include "render/toy_land.h"

namespace arete::render {
namespace {

class VertexStage : public GlTest {};

Land land_of(const ToyLand& toy) {
  Land land;
  land.world_from_post.m = {30, 2, 0, 1, -30, 0};
  land.cols = land.rows = toy.posts();
  land.z_min = -2000;
  land.z_max = 2000;
  return land;
}

View some_view() {
  Pose pose;
  pose.eye = {100, -200, 3000};
  pose.pitch = -0.8;
  return make_view(pose, 64, 64);
}

// Vertices whose drawn position is not the one that core computes.
int wrong_vertices(const DrawList& list, const BlockSource& blocks,
                   const std::vector<float>& drawn) {
  int wrong = 0;
  std::size_t i = 0;
  for (const DrawBatch& batch : list.batches) {
    const auto vertices = batch.vertices == kOwnBlock ? std::span<const Vertex>(list.vertices)
                                                      : blocks.vertices(batch.vertices);
    for (const Vertex& v : vertices) {
      const float z = morphed_z(v, batch.factor);
      const float w = v.slot[0] < kFactorCount ? batch.factor[v.slot[0]] : 0;
      const bool same = i + 2 < drawn.size() &&
                        std::abs(drawn[i + 2] - z) <= 1e-6F * std::max(1.0F, std::abs(z)) &&
                        drawn[i] == static_cast<float>(v.dcol) * w &&
                        drawn[i + 1] == static_cast<float>(v.drow) * w;
      wrong += same ? 0 : 1;
      i += 3;
    }
  }
  return drawn.size() == i ? wrong : -1;
}

TEST_F(VertexStage, EqualsMorphedZOfCore) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const ToyLand toy(3, seed, 2000);
    Renderer renderer(land_of(toy));
    const DrawList list = toy.whole(seed + 10);
    const auto drawn = renderer.vertex_stage(some_view(), list, toy);
    EXPECT_EQ(wrong_vertices(list, toy, drawn), 0);
  }
}

TEST_F(VertexStage, EqualsMorphedZForTheListsOwnVertices) {
  const ToyLand toy(1, 4, 500);
  Renderer renderer(land_of(toy));
  DrawList list = toy.whole(5);
  const auto block = toy.vertices(1);
  list.vertices.assign(block.begin(), block.end());
  list.batches[0].vertices = kOwnBlock;
  EXPECT_EQ(wrong_vertices(list, toy, renderer.vertex_stage(some_view(), list, toy)), 0);
}

TEST_F(VertexStage, ASwappedSlotIsFound) {
  ToyLand toy(2, 6, 2000);
  Renderer renderer(land_of(toy));
  const DrawList list = toy.whole(7);
  const auto drawn = renderer.vertex_stage(some_view(), list, toy);
  Vertex& v = toy.block(2)[17];
  v.slot = {3, 4, 5, 255};
  std::swap(v.slot[1], v.slot[2]);
  EXPECT_EQ(wrong_vertices(list, toy, drawn), 1);
}

}  // namespace
}  // namespace arete::render
