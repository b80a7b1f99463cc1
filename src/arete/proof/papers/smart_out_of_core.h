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

/// Rows of the table "out of core": the flight, a frame every 8 ms, with room for about half of the
/// record pages that it touches and for no more than an eighth of those stored; from cold caches (a
/// new engine, and the system's cache of the files dropped) in every run. Errors are pixels, and
/// `Defer` holds where nothing else is said; suffixes: _soar, _no_prefetch (smart with
/// prefetch=off). `say` is told what runs; it may throw to stop.
/// Throws: NotFound; Corrupt when the heights cannot be read.
std::vector<PaperRow> out_of_core(const store::Terrain& terrain, const LateSetting& setting,
                                  const std::function<void(std::string_view)>& say);

}  // namespace arete::proof::smart
