#pragma once

#include <array>

#include <glm/glm.hpp>

namespace arete::render {

inline constexpr int kClipLevels = 20;

/// std140 image of `Clip` in shaders/frame.glsl.
struct ClipBlock {
  glm::vec4 scale, levels, size, centre;
  std::array<glm::vec4, kClipLevels> origin;
};

/// std140 image of `FrameBlock` in shaders/frame.glsl.
struct FrameBlock {
  glm::mat4 clip_from_camera, camera_from_clip;
  glm::vec4 plan, eye_offset;
  glm::ivec4 eye_post;
  glm::vec4 sun, tint, haze, sky_zenith, sky_horizon, grain_origin;
  glm::ivec4 has;
  std::array<ClipBlock, 3> clips;
};
static_assert(sizeof(ClipBlock) == sizeof(glm::vec4) * (4 + kClipLevels));
static_assert(sizeof(FrameBlock) == sizeof(glm::vec4) * (4 + 4 + 10) + 3 * sizeof(ClipBlock));

}  // namespace arete::render
