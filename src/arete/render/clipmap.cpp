#include "arete/render/clipmap.h"

#include <algorithm>
#include <cmath>

namespace arete::render {
namespace {

constexpr int kLargestWindow = 2048;  // texels
constexpr std::uint64_t kNoTile = ~std::uint64_t{0};

int ceil_shift(int v, int shift) {
  return static_cast<int>((std::int64_t{v} + (std::int64_t{1} << shift) - 1) >> shift);
}

int texel_bytes(int channels) {
  return channels >= 3 ? 4 : channels;
}

GLenum storage_format(int channels) {
  if (channels == 1) return GL_R8;
  return channels == 2 ? GL_RG8 : GL_SRGB8_ALPHA8;  // colours are stored with the display's gamma
}

GLenum upload_format(int channels) {
  static constexpr GLenum kFormats[] = {GL_RED, GL_RG, GL_RGB, GL_RGBA};
  return kFormats[channels - 1];
}

}  // namespace

Clipmap::Clipmap(const RasterSource& source, std::uint64_t budget_bytes)
    : source_(source), shape_(source.shape()) {
  shape_.levels = std::min(shape_.levels, kClipLevels);
  if (!choose_size(budget_bytes)) return;
  while (glm::any(glm::greaterThan(tiles_of(whole_level_), tiles_))) ++whole_level_;
  ready_level_ = shape_.levels - 1;
  const int layers = shape_.levels - first_level_;
  held_.assign(static_cast<std::size_t>(layers) * static_cast<std::size_t>(tiles_.x) *
                   static_cast<std::size_t>(tiles_.y),
               kNoTile);
  texture_ = make_texture(GL_TEXTURE_2D_ARRAY);
  glTextureStorage3D(texture_.get(), 1, storage_format(shape_.channels),
                     tiles_.x * shape_.tile_size, tiles_.y * shape_.tile_size, layers);
  glTextureParameteri(texture_.get(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(texture_.get(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
}

glm::ivec2 Clipmap::tiles_of(int level) const {
  const int tile = shape_.tile_size;
  return {(ceil_shift(shape_.width, level) + tile - 1) / tile,
          (ceil_shift(shape_.height, level) + tile - 1) / tile};
}

std::uint64_t Clipmap::bytes_of(int first_level, int window) const {
  const glm::ivec2 tiles = glm::min(tiles_of(first_level), glm::ivec2(window / shape_.tile_size));
  return static_cast<std::uint64_t>(tiles.x) * static_cast<std::uint64_t>(tiles.y) *
         static_cast<std::uint64_t>(shape_.tile_size * shape_.tile_size) *
         static_cast<std::uint64_t>(texel_bytes(shape_.channels) * (shape_.levels - first_level));
}

bool Clipmap::choose_size(std::uint64_t budget_bytes) {
  int window = std::max(kLargestWindow, 2 * shape_.tile_size);
  while (window > 2 * shape_.tile_size && bytes_of(0, window) > budget_bytes) window /= 2;
  while (first_level_ < shape_.levels && bytes_of(first_level_, window) > budget_bytes) {
    ++first_level_;
  }
  if (first_level_ >= shape_.levels) return false;
  tiles_ = glm::min(tiles_of(first_level_), glm::ivec2(window / shape_.tile_size));
  bytes_ = bytes_of(first_level_, window);
  whole_level_ = first_level_;
  return true;
}

glm::ivec2 Clipmap::window_of(int level) const {
  const double tile_texels = std::ldexp(shape_.tile_size, level);
  const glm::ivec2 last = glm::max(tiles_of(level) - tiles_, glm::ivec2(0));
  const glm::ivec2 wish{static_cast<int>(std::lround(centre_.x / tile_texels)),
                        static_cast<int>(std::lround(centre_.y / tile_texels))};
  return glm::clamp(wish - tiles_ / 2, glm::ivec2(0), last);
}

int Clipmap::update(glm::dvec2 centre_post, int finest_useful, int max_tiles) {
  const double texels = std::ldexp(1.0, shape_.texels_per_post_log2);
  centre_ = glm::clamp(centre_post * texels + 0.5, glm::dvec2(0),
                       glm::dvec2(shape_.width, shape_.height));
  const int coarsest = shape_.levels - 1;
  const int finest =
      std::clamp(finest_useful + shape_.texels_per_post_log2, first_level_, coarsest);
  int left = std::max(1, max_tiles);
  const int allowed = left;
  ready_level_ = coarsest;
  for (int level = coarsest; level >= finest && fill(level, left); --level) ready_level_ = level;
  return allowed - left;
}

// False when tiles_left ran out before the level's window was complete.
bool Clipmap::fill(int level, int& tiles_left) {
  const glm::ivec2 first = window_of(level);
  const glm::ivec2 count = glm::min(tiles_of(level), tiles_);
  for (int y = first.y; y < first.y + count.y; ++y) {
    for (int x = first.x; x < first.x + count.x; ++x) {
      const TileId id{static_cast<std::uint32_t>(level), static_cast<std::uint32_t>(x),
                      static_cast<std::uint32_t>(y)};
      const glm::ivec2 place{x % tiles_.x, y % tiles_.y};
      const int slot = ((level - first_level_) * tiles_.y + place.y) * tiles_.x + place.x;
      std::uint64_t& held = held_[static_cast<std::size_t>(slot)];
      if (held == id.key()) continue;
      if (tiles_left == 0) return false;
      --tiles_left;
      upload(id, place);
      held = id.key();
    }
  }
  return true;
}

void Clipmap::upload(TileId id, glm::ivec2 place) {
  const int n = shape_.tile_size;
  Texels tile = source_.read(id);
  const auto bytes = static_cast<std::size_t>(n) * static_cast<std::size_t>(n) *
                     static_cast<std::size_t>(shape_.channels);
  if (tile.bytes.size() != bytes) tile.bytes.assign(bytes, shape_.fill);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage3D(texture_.get(), 0, place.x * n, place.y * n,
                      static_cast<int>(id.level) - first_level_, n, n, 1,
                      upload_format(shape_.channels), GL_UNSIGNED_BYTE, tile.bytes.data());
}

ClipBlock Clipmap::block(glm::ivec2 eye_post) const {
  const double texels = std::ldexp(1.0, shape_.texels_per_post_log2);
  const glm::dvec2 eye = glm::dvec2(eye_post) * texels + 0.5;
  const glm::dvec2 size = glm::dvec2(tiles_) * static_cast<double>(shape_.tile_size);
  // A window's centre lies within half a tile of the camera; two texels are the filter's.
  const double reach = (std::max(tiles_.x, tiles_.y) - 1) * 0.5 * shape_.tile_size - 2;
  ClipBlock b{};
  b.scale = glm::dvec4(texels, std::max(1.0, reach / 2), 1 / size.x, 1 / size.y);
  b.levels = glm::vec4(first_level_, ready_level_, whole_level_, shape_.levels - 1);
  b.size = glm::dvec4(shape_.width, shape_.height, eye.x, eye.y);
  b.centre = glm::dvec4(centre_ - eye, 0, 0);
  for (int level = first_level_; level < shape_.levels; ++level) {
    const glm::dvec2 turns = eye / (size * std::ldexp(1.0, level));
    b.origin[static_cast<std::size_t>(level)] = glm::dvec4(turns - glm::floor(turns), 0, 0);
  }
  return b;
}

}  // namespace arete::render
