#include <algorithm>
#include <random>

#include "arete/core/error.h"

#include "render/gl_test.h"
#include "render/toy_land.h"

namespace arete::render {
namespace {

constexpr std::size_t kTiny = std::size_t{352} << 10U;

class GpuMemory : public GlTest {};

Land land_of(const ToyLand& toy) {
  Land land;
  land.world_from_post.m = {10, 0, 0, 0, -10, 0};
  land.cols = land.rows = toy.posts();
  land.z_min = -100;
  land.z_max = 400;
  return land;
}

View view_of(const ToyLand& toy) {
  const double side = (toy.posts() - 1) * 10.0;
  Pose pose;
  pose.eye = {side / 2, -side * 1.1, side / 2};
  pose.pitch = -0.7;
  return make_view(pose, 96, 96);
}

TEST_F(GpuMemory, BlocksAreUploadedOnce) {
  const ToyLand toy(4, 1, 20);
  Renderer renderer(land_of(toy));
  const DrawList list = toy.whole(1);
  shoot(renderer, view_of(toy), list, toy, Style{});
  const std::uint64_t first = renderer.stats().bytes_uploaded;
  EXPECT_GE(first, 16U * 17 * 17 * sizeof(Vertex));
  shoot(renderer, view_of(toy), list, toy, Style{});
  EXPECT_LT(renderer.stats().bytes_uploaded, 16U * 128);  // factors and commands only
}

TEST_F(GpuMemory, EvictionKeepsThePictureAndTheCap) {
  const ToyLand toy(6, 2, 20);  // 36 blocks of 9.2 kB: more than the tiny memory holds
  Renderer ample(land_of(toy));
  Renderer tiny(land_of(toy), kTiny);
  const View view = view_of(toy);
  for (int frame = 0; frame < 24; ++frame) {
    std::vector<int> tiles;
    for (int i = 0; i < 20; ++i) tiles.push_back((frame * 7 + i) % toy.tiles());
    const DrawList list = toy.list(tiles, static_cast<std::uint64_t>(frame));
    const Picture expected = shoot(ample, view, list, toy, Style{});
    ASSERT_EQ(different_pixels(expected, shoot(tiny, view, list, toy, Style{})), 0) << frame;
    ASSERT_LE(tiny.stats().gpu_bytes, kTiny);
    ASSERT_EQ(tiny.stats().dropped_batches, 0U);
  }
}

TEST_F(GpuMemory, WhatDoesNotFitIsCounted) {
  const ToyLand toy(8, 2, 20);
  Renderer tiny(land_of(toy), kTiny);
  Frame frame(64, 64);
  tiny.draw(view_of(toy), toy.whole(1), toy, Style{}, frame);
  EXPECT_GT(tiny.stats().dropped_batches, 0U);
  EXPECT_GT(tiny.stats().draws, 10U);
  EXPECT_EQ(tiny.stats().draws + tiny.stats().dropped_batches, 64U);
  EXPECT_LE(tiny.stats().gpu_bytes, kTiny);
}

// Blocks of many sizes that come and go leave the room in pieces; what fits as a whole is drawn.
TEST_F(GpuMemory, WhatVertexRoomPromisesIsDrawn) {
  ToyLand toy(8, 2, 20);
  std::mt19937_64 random(7);
  std::vector<std::uint32_t> rows;
  for (int t = 0; t < toy.tiles(); ++t) {
    rows.push_back(2 + static_cast<std::uint32_t>(random() % 16));
    toy.block(t).resize(rows.back() * (ToyLand::kTileCells + 1));
  }
  Renderer ample(land_of(toy));
  Renderer tiny(land_of(toy), kTiny);
  const View view = view_of(toy);
  const std::uint64_t room =
      tiny.vertex_room(toy.indices(1).size_bytes(), static_cast<std::uint64_t>(toy.tiles()));
  EXPECT_LT(room, kTiny);
  std::uint64_t again = 0;
  for (int frame = 0; frame < 200; ++frame) {
    std::vector<int> tiles;
    std::uint64_t named = 0;
    for (int tries = 0; tries < 100; ++tries) {
      const int t = static_cast<int>(random() % static_cast<std::uint64_t>(toy.tiles()));
      const std::uint64_t bytes = toy.block(t).size() * sizeof(Vertex);
      if (named + bytes > room || std::ranges::count(tiles, t) != 0) continue;
      named += bytes;
      tiles.push_back(t);
    }
    DrawList list = toy.list(tiles, 1);
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      list.batches[i].index_count =
          6 * ToyLand::kTileCells * (rows[static_cast<std::size_t>(tiles[i])] - 1);
    }
    const Picture picture = shoot(tiny, view, list, toy, Style{});
    ASSERT_EQ(tiny.stats().dropped_batches, 0U) << frame;
    ASSERT_LE(tiny.stats().gpu_bytes, kTiny);
    again += tiny.stats().bytes_uploaded > named ? 1 : 0;
    if (frame % 20 == 0) {
      EXPECT_EQ(different_pixels(shoot(ample, view, list, toy, Style{}), picture), 0);
    }
  }
  EXPECT_GT(again, 0U);  // the control: some frames did find the room in pieces
}

TEST_F(GpuMemory, TooLittleIsRefused) {
  const ToyLand toy(1, 2, 20);
  try {
    const Renderer renderer(land_of(toy), 1000);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::Limit);
  }
}

TEST_F(GpuMemory, TheArenaGrowsWithoutLosingBlocks) {
  const ToyLand toy(64, 3, 20);  // 38 MB: beyond the arena's first size
  const Land land = land_of(toy);
  Renderer renderer(land);
  const View view = view_of(toy);
  const DrawList some = toy.list({4000, 4001, 4002}, 1);
  const Picture before = shoot(renderer, view, some, toy, Style{});
  shoot(renderer, view, toy.whole(2), toy, Style{});
  EXPECT_EQ(renderer.stats().dropped_batches, 0U);
  EXPECT_EQ(different_pixels(before, shoot(renderer, view, some, toy, Style{})), 0);
  EXPECT_LT(renderer.stats().bytes_uploaded, 1000U);
}

TEST_F(GpuMemory, AppendedVerticesArrive) {
  ToyLand toy(2, 4, 20);
  std::vector<Vertex>& block = toy.block(0);
  const std::vector<Vertex> all = toy.block(3);
  block.assign(all.begin(), all.begin() + 34);  // two rows
  DrawList list = toy.list({0}, 1);
  Renderer renderer(land_of(toy));
  const View view = view_of(toy);
  list.batches[0].index_count = 6 * ToyLand::kTileCells;
  list.uploads = {{1, 0, 34}};
  shoot(renderer, view, list, toy, Style{});
  for (std::uint32_t rows = 3; rows <= 17; ++rows) {
    const auto held = static_cast<std::uint32_t>(block.size());
    block.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(rows * 17));
    list.batches[0].index_count = 6 * ToyLand::kTileCells * (rows - 1);
    list.uploads = {{1, held, rows * 17 - held}};
    if (rows % 3 == 0) continue;  // refined, but not drawn
    Renderer fresh(land_of(toy));
    const Picture expected = shoot(fresh, view, list, toy, Style{});
    ASSERT_EQ(different_pixels(expected, shoot(renderer, view, list, toy, Style{})), 0) << rows;
  }
}

TEST_F(GpuMemory, ChangedIndicesArrive) {
  ToyLand toy(2, 4, 20);
  std::vector<std::uint32_t>& block = toy.index_block();
  const std::vector<std::uint32_t> all = block;
  Renderer renderer(land_of(toy));
  const View view = view_of(toy);
  DrawList list = toy.list({0, 3}, 1);
  const auto draw_from = [&](std::size_t first, std::size_t count) {
    block.assign(all.begin() + static_cast<std::ptrdiff_t>(first),
                 all.begin() + static_cast<std::ptrdiff_t>(first + count));
    for (DrawBatch& batch : list.batches) batch.index_count = static_cast<std::uint32_t>(count);
    list.uploads = {{1, 0, static_cast<std::uint32_t>(count), BlockKind::Indices}};
  };
  draw_from(0, 300);
  shoot(renderer, view, list, toy, Style{});
  for (const std::size_t count : {300, 240, 420, 900}) {  // in its room, less, more, beyond it
    draw_from(all.size() - count, count);
    Renderer fresh(land_of(toy));
    const Picture expected = shoot(fresh, view, list, toy, Style{});
    ASSERT_EQ(different_pixels(expected, shoot(renderer, view, list, toy, Style{})), 0) << count;
  }
  draw_from(0, 900);
  list.uploads.clear();  // unsaid changes are not looked for
  Renderer fresh(land_of(toy));
  const Picture expected = shoot(fresh, view, list, toy, Style{});
  EXPECT_GT(different_pixels(expected, shoot(renderer, view, list, toy, Style{})), 50);
}

TEST_F(GpuMemory, ForgottenBlocksAreReadAgain) {
  ToyLand toy(2, 4, 20);
  Renderer renderer(land_of(toy));
  const View view = view_of(toy);
  const DrawList list = toy.whole(1);
  const Picture before = shoot(renderer, view, list, toy, Style{});
  for (Vertex& v : toy.block(1)) v.z += 60;
  EXPECT_EQ(different_pixels(before, shoot(renderer, view, list, toy, Style{})), 0);
  renderer.forget(toy);
  EXPECT_GT(different_pixels(before, shoot(renderer, view, list, toy, Style{})), 50);
}

}  // namespace
}  // namespace arete::render
