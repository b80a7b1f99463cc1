#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "arete/core/draw_list.h"
#include "arete/render/renderer.h"
#include "arete/store/terrain.h"

namespace arete::app {

/// The last frames' times as a ring, for the graph.
class FrameTimes {
 public:
  void add(float ms);
  float mean_ms() const;
  float max_ms() const;
  const std::array<float, 120>& ring() const { return ms_; }
  int next() const { return static_cast<int>(next_); }

 private:
  std::array<float, 120> ms_{};
  std::size_t next_ = 0, count_ = 0;
};

/// What the user can turn.
struct Knobs {
  static constexpr int kAllTriangles = 10'000'000;  ///< and more: no limit
  float tolerance_px = 1;
  int triangles = kAllTriangles;
  int cache_mib = 512, gpu_mib = 1024;
};

/// What the user asked for by the panel.
struct Wishes {
  std::optional<std::string> method;
  bool memory = false;  ///< cache_mib or gpu_mib were set
};

/// What the overlay says about one frame.
struct OverlayText {
  std::string_view method, mode;
  const std::vector<std::string>& methods;  ///< that the store holds
  const RefineStats& refine;
  const render::DrawStats& draw;
  store::CacheStats cache;
  std::uint64_t cache_bytes, gpu_bytes;  ///< all that the budgets cap
  std::size_t cache_budget, gpu_budget;
  std::string place;  ///< under the cursor, and how high: a line or two
  double eye_height;  ///< metres above the ground
  bool frozen, wireframe;
};

enum class Mood { Note, Working, Failure };

/// A line at the foot of the window.
struct Notice {
  std::string text;
  Mood mood = Mood::Note;
  double done = 0;  ///< 0..1, Working only
};

/// Colours and shapes. Requires: an ImGui context.
void style_overlay();
/// Draws the panel of numbers and knobs.
Wishes draw_overlay(const OverlayText& text, const FrameTimes& times, Knobs& knobs);
/// Draws the lines, the last one lowest.
void draw_notices(const std::vector<Notice>& notices);
void draw_help();

}  // namespace arete::app
