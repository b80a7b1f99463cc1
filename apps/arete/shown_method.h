#pragma once

#include <memory>
#include <string>

#include "arete/lod/engine.h"
#include "arete/render/renderer.h"

#include "open_store.h"

namespace arete::app {

/// One method on the screen: its engine, a renderer for its blocks, and the latest list.
class ShownMethod {
 public:
  /// `terrain` and the sources of `land` must outlive it.
  ShownMethod(const TerrainFlags& flags, const std::string& method, const store::Terrain& terrain,
              const render::Land& land, std::size_t gpu_memory);

  void refine(const View& view, const lod::RefineOptions& options);
  /// Draws the latest list, perhaps from another camera than it was refined for.
  void draw(const View& view, const render::Style& style, render::Frame& frame);

  bool refined() const { return refined_; }  ///< false before the first refine
  const std::string& name() const { return name_; }
  const RefineStats& refine_stats() const { return list_.stats; }
  const render::DrawStats& draw_stats() const { return renderer_.stats(); }

 private:
  std::string name_;
  std::unique_ptr<lod::Engine> engine_;
  render::Renderer renderer_;
  DrawList list_;
  bool refined_ = false;
};

}  // namespace arete::app
