#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include "arete/core/heightfield.h"
#include "arete/lod/engine.h"
#include "arete/proof/leaks.h"
#include "arete/scene/path.h"

namespace arete::proof {

/// What float rounding may add to a screen distance. Vertices are drawn as floats: half a unit in
/// the last place of a height of some kilometres is 0.1 mm, seen from a few hundred metres, where
/// an engine may first use its whole tolerance, that is less than this.
inline constexpr double kRoundingPx = 1e-3;

struct VerifyOptions {
  int frames = 300;
  int width = 1280, height = 720;
  int threads = 2;
  lod::RefineOptions refine;
  std::size_t gpu_memory = std::size_t{1} << 30U;  ///< of GlPicture; the budget is cut to it
  std::optional<std::filesystem::path> dump;       ///< each frame as binary PLY + camera JSON
  DrawDepth draw_depth;                            ///< draws the pictures; empty = GlPicture
  std::function<void(double done)> progress;
};

/// DESIGN.md section 5, `verify --json`. Pixels unless named otherwise.
struct VerifyReport {
  lod::Claims claims;  ///< at max_tolerance_px
  int frames = 0;
  double tolerance_px = 0;
  double max_error_px = 0, p999_error_px = 0, max_error_angular_px = 0;
  std::uint64_t cracks = 0, t_junctions = 0, background_pixels = 0;
  double max_pop_px = 0, p999_pop_px = 0;
  /// Pop / that pair's promise (Claims::pop_px x relative motion); <= 1 holds. Of pairs with the
  /// eye outside every drawn tile's box: inside one D is 0 and nothing is promised.
  double max_pop_share = 0;
  int unpromised_pairs = 0;
  std::uint64_t undrawn_posts = 0;  ///< counted posts in the viewport that no triangle covers
  double mean_triangles = 0;
  std::uint64_t max_triangles = 0;
  std::uint64_t max_vertex_bytes = 0;  ///< of the blocks and vertices that a list names
  int over_budget_frames = 0;          ///< more than the budget, or coarser with none
  double max_tolerance_px = 0;         ///< the largest that the engine used in the flight
  double achieved_error_px = 0;        ///< the engine's own worst bound in the flight
  /// Frames whose error is beyond the claim at the tolerance that they used, or beyond the engine's
  /// own bound.
  int broken_bounds = 0;
  double seconds = 0;
  bool holds() const;  ///< every claim is kept
};

/// Flies the path and measures every frame from the DrawList and `dem` alone. Every tenth frame
/// is also checked as a whole, without culling.
/// Throws: Unsupported when `draw_depth` is empty and there is no OpenGL to draw the pictures
/// with; Limit when a frame does not fit the GPU memory; Io from dumping.
VerifyReport verify(lod::Engine& engine, const Heightfield& dem, const scene::Path& path,
                    const VerifyOptions& options);

}  // namespace arete::proof
