#include "render/toy_land.h"

#include <cmath>
#include <numeric>
#include <random>

namespace arete::render {
namespace {

using Random = std::mt19937_64;

Vertex random_vertex(Post post, double relief_m, Random& random) {
  std::uniform_real_distribution<double> metres(-relief_m, relief_m);
  std::uniform_int_distribution<int> slot(0, 15);
  std::uniform_int_distribution<int> shift(-1, 1);
  Vertex v;
  v.post = post;
  v.z = static_cast<float>(metres(random));
  for (float& d : v.dz) d = static_cast<float>(metres(random) / 4);
  for (std::uint8_t& s : v.slot) s = static_cast<std::uint8_t>(slot(random));
  if (relief_m > 0) {
    v.dcol = static_cast<std::int16_t>(shift(random));
    v.drow = static_cast<std::int16_t>(shift(random));
  }
  if (slot(random) == 0) v.slot[2] = 255;
  return v;
}

}  // namespace

ToyLand::ToyLand(int tiles, std::uint64_t seed, double relief_m) : tiles_(tiles) {
  Random random(seed);
  constexpr int n = kTileCells;
  for (int t = 0; t < tiles * tiles; ++t) {
    std::vector<Vertex>& block = blocks_.emplace_back();
    for (int r = 0; r <= n; ++r) {
      for (int c = 0; c <= n; ++c) {
        block.push_back(random_vertex({t % tiles * n + c, t / tiles * n + r}, relief_m, random));
      }
    }
  }
  for (int r = 0; r < n; ++r) {
    for (int c = 0; c < n; ++c) {
      const auto nw = static_cast<std::uint32_t>(r * (n + 1) + c);
      const std::uint32_t sw = nw + n + 1;
      for (const std::uint32_t i : {nw, sw, nw + 1, nw + 1, sw, sw + 1}) indices_.push_back(i);
    }
  }
}

std::span<const Vertex> ToyLand::vertices(BlockKey key) const {
  return blocks_[static_cast<std::size_t>(key - 1)];
}

std::span<const std::uint32_t> ToyLand::indices(BlockKey) const {
  return indices_;
}

DrawList ToyLand::list(const std::vector<int>& tiles, std::uint64_t seed) const {
  Random random(seed);
  std::uniform_real_distribution<float> factor(0, 1);
  DrawList list;
  for (const int t : tiles) {
    DrawBatch batch;
    batch.vertices = static_cast<BlockKey>(t) + 1;
    batch.indices = 1;
    batch.index_count = static_cast<std::uint32_t>(indices_.size());
    for (float& f : batch.factor) f = factor(random);
    list.batches.push_back(batch);
  }
  return list;
}

DrawList ToyLand::whole(std::uint64_t seed) const {
  std::vector<int> all(static_cast<std::size_t>(tiles()));
  std::iota(all.begin(), all.end(), 0);
  return list(all, seed);
}

ToyRaster::ToyRaster(int width, int height, int channels, int tile_size, Texel texel)
    : texel_(std::move(texel)) {
  shape_.width = width;
  shape_.height = height;
  shape_.channels = channels;
  shape_.tile_size = tile_size;
  shape_.levels = 1;
  while ((std::max(width, height) - 1) >> (shape_.levels - 1) >= tile_size) ++shape_.levels;
}

Texels ToyRaster::read(TileId id) const {
  ++reads_;
  Texels tile;
  tile.size = shape_.tile_size;
  tile.channels = shape_.channels;
  const int level = static_cast<int>(id.level);
  for (int r = 0; r < tile.size; ++r) {
    for (int c = 0; c < tile.size; ++c) {
      const int x = static_cast<int>(id.x) * tile.size + c;
      const int y = static_cast<int>(id.y) * tile.size + r;
      for (int k = 0; k < tile.channels; ++k) tile.bytes.push_back(texel_(level, x, y, k));
    }
  }
  return tile;
}

glm::dvec3 hit_plane(const View& view, double x, double y) {
  const glm::dvec4 clip(2 * x / view.viewport_width - 1, 2 * y / view.viewport_height - 1, 0, 1);
  const glm::dvec3 direction(glm::inverse(clip_from_camera(view)) * clip);
  const double t = -view.eye.z / direction.z;
  const glm::dvec3 hit = view.eye + t * direction;
  return {hit.x, hit.y, t * glm::dot(direction, view.forward())};
}

}  // namespace arete::render
