#pragma once

#include <algorithm>
#include <functional>
#include <utility>

#include "arete/lod/engine.h"

#include "mesh/toy_surface.h"

namespace arete::toy {

/// Draws every cell (with culling on, those within reach of the eye) in square patches of their
/// own vertices. `spoil` may plant a fault in the list of the n-th refine.
class ToyEngine : public lod::Engine {
 public:
  static constexpr int kPatch = 8;                                      // cells a side
  lod::Claims claimed{.conforming = true, .error_px = 1, .pop_px = 1};  ///< at 1 px
  double achieved_px = 0.25, tolerance_px = 1;                          ///< what the stats say
  float raise = 0;   ///< metres added to every vertex
  int reach = 1000;  ///< posts from the eye that are drawn with culling on
  std::function<void(DrawList&, int refine)> spoil;

  explicit ToyEngine(const Heightfield& dem) : dem_(dem) {}

  void refine(const View& view, const lod::RefineOptions& options, DrawList& out) override {
    out.clear();
    const glm::dvec2 eye = dem_.georef().world_from_post.inverse({view.eye.x, view.eye.y});
    for (int r = 0; r + 1 < dem_.rows(); r += kPatch) {
      for (int c = 0; c + 1 < dem_.cols(); c += kPatch) {
        const bool near = std::abs(c - eye.x) < reach && std::abs(r - eye.y) < reach;
        if (near || !options.cull) add_patch({c, r}, out);
      }
    }
    out.stats.achieved_error_px = achieved_px;
    out.stats.tolerance_px = tolerance_px;
    if (spoil) spoil(out, refines_);
    ++refines_;
  }
  lod::Claims claims(const lod::RefineOptions& options) const override {
    lod::Claims claims = claimed;
    claims.error_px *= options.tolerance_px;
    claims.pop_px *= options.tolerance_px;
    return claims;
  }
  lod::Footprint footprint() const override { return {}; }
  std::span<const Vertex> vertices(BlockKey) const override { return {}; }
  std::span<const std::uint32_t> indices(BlockKey) const override { return {}; }

 private:
  void add_patch(Post nw, DrawList& out) const {
    const int cols = std::min(kPatch, dem_.cols() - 1 - nw.col) + 1;
    const int rows = std::min(kPatch, dem_.rows() - 1 - nw.row) + 1;
    const auto first = static_cast<std::uint32_t>(out.vertices.size());
    DrawBatch batch;
    batch.first_index = static_cast<std::uint32_t>(out.indices.size());
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < cols; ++c) {
        Vertex v;
        v.post = {nw.col + c, nw.row + r};
        v.z = dem_[v.post] + raise;
        out.vertices.push_back(v);
      }
    }
    for (const Triangle& t : all_cells(cols, rows)) {
      for (const Post p : t) {
        out.indices.push_back(first + static_cast<std::uint32_t>(p.row * cols + p.col));
      }
    }
    batch.index_count = static_cast<std::uint32_t>(out.indices.size()) - batch.first_index;
    out.batches.push_back(batch);
  }

  const Heightfield& dem_;
  int refines_ = 0;
};

}  // namespace arete::toy
