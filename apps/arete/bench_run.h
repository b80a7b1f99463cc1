#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "flags.h"

namespace arete::app {

enum class Drawing { Draw, Skip };

/// Sums and samples of one method over one path.
struct BenchRun {
  std::string method;
  int frames = 0;
  double mean_triangles = 0;
  double mean_full_triangles = 0;                    ///< of full resolution in the same places
  std::vector<double> triangles;                     ///< one a frame
  std::vector<double> refine_ms, draw_ms, frame_ms;  ///< one a frame; draw_ms empty when skipped
  std::uint64_t evaluated_vertices = 0, visited_nodes = 0, late_blocks = 0;
  std::uint64_t bytes_read = 0, page_faults = 0, bytes_uploaded = 0;
  double incoherence_percent = 0;
  std::uint64_t cache_bytes_max = 0;     ///< decoded tiles
  std::uint64_t resident_bytes_max = 0;  ///< vertices that the engine held
  std::uint64_t terrain_bytes_max = 0;   ///< both and tables: what --cache caps
  std::uint64_t gpu_bytes_max = 0, peak_rss_bytes = 0, max_triangles = 0;
  double achieved_error_px = 0;
  double tolerance_px = 0;  ///< the largest used
};

/// The smallest sample that at least `share` of the samples do not exceed; 0 of none.
double quantile(std::vector<double> samples, double share);

/// Flies the path with a freshly opened terrain. Requires: a current OpenGL context when drawing.
BenchRun bench_method(const FlightFlags& flags, const std::string& method, Drawing drawing);

}  // namespace arete::app
