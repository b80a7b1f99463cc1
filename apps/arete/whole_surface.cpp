#include "whole_surface.h"

#include <algorithm>
#include <numbers>

#include "arete/core/screen_error.h"

namespace arete::app {
namespace {

struct FarView {
  View view;
  double farthest_m;  ///< from the eye to the terrain
};

// Engines refine for an eye. One that is high enough has every part of the terrain at nearly the
// same distance (within 1e-4 of it), so a screen tolerance means the same number of metres
// everywhere.
FarView far_above(const store::Manifest& m) {
  const Affine2& a = m.georef.world_from_post;
  const glm::dvec2 corner = a.apply(m.cols - 1, m.rows - 1);
  const double extent = glm::length(corner) + (m.z_max - m.z_min) + 1;
  const double height = 1e4 * extent;
  Pose pose;
  pose.eye = {corner / 2.0, m.z_max + height};
  pose.pitch = -std::numbers::pi / 2;
  pose.near_m = height / 2;
  return {make_view(pose, 1024, 1024), height + extent};
}

}  // namespace

mesh::Surface whole_surface(lod::Engine& engine, const store::Manifest& manifest,
                            double max_error_m) {
  const auto [view, farthest_m] = far_above(manifest);
  lod::RefineOptions options;
  options.scale = ErrorScale::Angular;
  options.cull = false;
  // tau D / alpha metres are allowed at distance D: max_error_m at the farthest post.
  options.tolerance_px = max_error_m * pixel_scale(view, ErrorScale::Angular) / farthest_m;
  DrawList list;
  engine.refine(view, options, list);
  mesh::Surface surface;
  mesh::flatten(list, engine, surface);
  return surface;
}

bool touches_drawable_cell(const std::array<Post, 3>& corners, const Heightfield& dem) {
  const auto [west, east] = std::minmax({corners[0].col, corners[1].col, corners[2].col});
  const auto [north, south] = std::minmax({corners[0].row, corners[1].row, corners[2].row});
  for (int row = north; row < std::min(south, dem.rows() - 1); ++row) {
    for (int col = west; col < std::min(east, dem.cols() - 1); ++col) {
      if (dem.drawable({col, row})) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace arete::app
