#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arete/scene/path.h"
#include "arete/store/terrain.h"

namespace arete::proof {

/// A quantity of a paper beside what this run measured (DESIGN.md section 5, `bench --paper`).
struct PaperRow {
  std::string table;     ///< of the paper: "Figure 9"
  std::string quantity;  ///< median of the default mode; _mean, _max, _literal ... suffix others
  std::string setting;   ///< the *published* setting; what was reached is a row of its own
  std::optional<double> published, measured;
  std::string unit;
  std::string note;
};

struct PaperOptions {
  int frames = 300;  ///< of each run
  /// Told what runs now and how much of the whole is done, 0..1. It may throw to stop.
  std::function<void(std::string_view what, double done)> progress;
};

/// A paper's own experiment, made on any terrain.
struct Paper {
  std::string_view name;                      ///< as on the command line
  std::string_view citation;                  ///< key in docs/papers.bib
  std::span<const std::string_view> methods;  ///< that the store must have been built with
  std::vector<PaperRow> (*run)(const store::Terrain&, const scene::Path&, const PaperOptions&);
};

std::span<const Paper> papers();
/// Throws: Usage, listing the names.
const Paper& find_paper(std::string_view name);

}  // namespace arete::proof
