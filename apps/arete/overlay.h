#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

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

/// What the overlay says about one frame.
struct OverlayText {
  std::string_view method, mode, message;
  const RefineStats& refine;
  const render::DrawStats& draw;
  store::CacheStats cache;
  std::size_t cache_budget, gpu_budget;
  std::optional<glm::dvec3> under_cursor;  ///< CRS x, y and height in metres
  double eye_height;                       ///< metres above the ground
  bool frozen;
};

/// Draws the panel of numbers; `tolerance_px` is the slider's.
void draw_overlay(const OverlayText& text, const FrameTimes& times, float& tolerance_px);
void draw_help();

}  // namespace arete::app
