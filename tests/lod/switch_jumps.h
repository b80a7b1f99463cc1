#pragma once

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "arete/lod/engine.h"
#include "arete/mesh/surface.h"
#include "arete/proof/pop.h"

namespace arete::lod {

/// What the surface does at the instants at which the blocks of a list change.
struct SwitchJumps {
  int switches = 0;
  double max_px = 0;
};

/// Finds up to `most` switches between two instants of a flight by halving the time between them to
/// `instant`, and measures how far the surface moves on the screen across each. Nothing is culled,
/// so that only levels change lists.
class SwitchWatch {
 public:
  SwitchWatch(Engine& engine, const proof::Reference& reference, double tolerance_px)
      : engine_(engine), reference_(reference), tolerance_px_(tolerance_px) {}

  SwitchJumps measure(const std::function<View(double)>& view_at, double from, double to,
                      int most) {
    constexpr double kInstant = 1e-9;
    SwitchJumps jumps;
    while (jumps.switches < most) {
      const Blocks start = draw(view_at(from), before_);
      double lo = from;
      double hi = to;
      if (draw(view_at(hi), after_) == start) return jumps;
      while (hi - lo > kInstant) {
        const double middle = (lo + hi) / 2;
        (draw(view_at(middle), after_) == start ? lo : hi) = middle;
      }
      draw(view_at(lo), before_);
      draw(view_at(hi), after_);
      const View earlier = view_at(lo);
      const View later = view_at(hi);
      const auto pops = proof::measure_pops({earlier, later, before_, after_}, reference_, 2);
      jumps.max_px = std::max(jumps.max_px, pops.max_px());
      ++jumps.switches;
      from = hi;
    }
    return jumps;
  }

 private:
  using Blocks = std::vector<std::pair<BlockKey, BlockKey>>;

  Blocks draw(const View& view, mesh::Surface& surface) {
    engine_.refine(view, {.tolerance_px = tolerance_px_, .cull = false}, list_);
    mesh::flatten(list_, engine_, surface);
    Blocks blocks;
    for (const DrawBatch& batch : list_.batches) blocks.emplace_back(batch.vertices, batch.indices);
    return blocks;
  }

  Engine& engine_;
  const proof::Reference& reference_;
  double tolerance_px_;
  DrawList list_;
  mesh::Surface before_, after_;
};

}  // namespace arete::lod
