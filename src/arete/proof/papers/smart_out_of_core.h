#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "arete/core/view.h"
#include "arete/proof/papers/paper.h"

namespace arete::proof::smart {

/// What is flown out of core.
struct LateSetting {
  std::string text;  ///< of its rows; the pages are added
  double tolerance_px;
  std::vector<View> flight;
};

/// Told what runs and how much of the part is done, 0..1, after every frame; it may throw to stop.
using Progress = std::function<void(std::string_view what, double done)>;

/// Rows of the table "out of core": the flight, a frame every 8 ms, from cold caches (a new engine,
/// and the system's cache of the files dropped) in every run. There is room for half of the record
/// pages that the flight touches or, where that is more, for twice what a frame of soar touches,
/// but for no more than an eighth of those stored. Where that cannot hold two frames, or holds the
/// whole flight, nothing is flown and a single row says so. Errors are pixels, and `Defer` holds
/// where nothing else is said; suffixes: _soar, _no_prefetch (smart with prefetch=off).
/// Throws: NotFound; Corrupt when the heights cannot be read; what `progress` throws.
std::vector<PaperRow> out_of_core(const store::Terrain& terrain, const LateSetting& setting,
                                  const Progress& progress);

}  // namespace arete::proof::smart
