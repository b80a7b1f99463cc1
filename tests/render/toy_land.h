#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "arete/core/draw_list.h"
#include "arete/core/raster_source.h"
#include "arete/core/view.h"

namespace arete::render {

/// Tiles of kTileCells^2 cells over a square grid of `tiles` x `tiles`, every vertex with random
/// deltas and slots. Tile t has vertex block 1 + t; index block 1 is shared by all.
class ToyLand : public BlockSource {
 public:
  static constexpr int kTileCells = 16;
  ToyLand(int tiles, std::uint64_t seed, double relief_m);
  std::span<const Vertex> vertices(BlockKey key) const override;
  std::span<const std::uint32_t> indices(BlockKey key) const override;
  int posts() const { return tiles_ * kTileCells + 1; }
  int tiles() const { return tiles_ * tiles_; }
  /// One batch for each tile named, with random factors of the seed.
  DrawList list(const std::vector<int>& tiles, std::uint64_t seed) const;
  DrawList whole(std::uint64_t seed) const;
  std::vector<Vertex>& block(int tile) { return blocks_[static_cast<std::size_t>(tile)]; }
  std::vector<std::uint32_t>& index_block() { return indices_; }

 private:
  int tiles_;
  std::vector<std::vector<Vertex>> blocks_;
  std::vector<std::uint32_t> indices_;
};

/// A pyramid computed texel by texel.
class ToyRaster : public RasterSource {
 public:
  using Texel = std::function<std::uint8_t(int level, int x, int y, int channel)>;
  ToyRaster(int width, int height, int channels, int tile_size, Texel texel);
  void set_texels_per_post_log2(int log2) { shape_.texels_per_post_log2 = log2; }
  RasterShape shape() const override { return shape_; }
  Texels read(TileId id) const override;
  int reads() const { return reads_; }

 private:
  RasterShape shape_;
  Texel texel_;
  mutable int reads_ = 0;
};

/// Where the ray through a pixel's centre (x right,
/// y up) meets the plane z = 0: x and y in metres, then the distance along the view axis, <= 0 =
/// never.
glm::dvec3 hit_plane(const View& view, double x, double y);

}  // namespace arete::render
