#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "arete/core/raster_source.h"
#include "arete/render/frame_block.h"
#include "arete/render/gl_object.h"

namespace arete::render {

/// The part of a pyramid that a camera needs, as an array texture: a window of each level around
/// the camera's ground point, every layer the same number of texels, so that coarser layers reach
/// further. Windows move by whole tiles and wrap around: only tiles that came into reach are read.
class Clipmap {
 public:
  /// Takes at most budget_bytes: first the windows shrink, then the finest levels are left out.
  /// Empty (texture() = 0) when even the coarsest level does not fit. The source must outlive it.
  Clipmap(const RasterSource& source, std::uint64_t budget_bytes);

  /// Moves the windows to the post and reads what is missing, coarsest level first, at most
  /// `max_tiles` tiles (and at least the coarsest level); levels below `finest_useful` are left
  /// alone. Returns the number of tiles read.
  int update(glm::dvec2 centre_post, int finest_useful, int max_tiles);
  /// What the shaders must know, relative to the eye's post.
  ClipBlock block(glm::ivec2 eye_post) const;

  GLuint texture() const { return texture_.get(); }
  std::uint64_t bytes() const { return bytes_; }
  const RasterShape& shape() const { return shape_; }

 private:
  bool choose_size(std::uint64_t budget_bytes);
  std::uint64_t bytes_of(int first_level, int window) const;
  glm::ivec2 tiles_of(int level) const;
  glm::ivec2 window_of(int level) const;
  bool fill(int level, int& tiles_left);
  void upload(TileId id, glm::ivec2 place);

  const RasterSource& source_;
  RasterShape shape_;
  GlTexture texture_;
  std::uint64_t bytes_ = 0;
  glm::ivec2 tiles_{0};  // of a window
  int first_level_ = 0, whole_level_ = 0, ready_level_ = 0;
  glm::dvec2 centre_{0};             // level-0 texels
  std::vector<std::uint64_t> held_;  // tile keys by level, row, column of the array
};

}  // namespace arete::render
