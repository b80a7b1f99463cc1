#include "arete/proof/papers/smart.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>

#include <fmt/format.h>

#include "arete/lod/engine.h"
#include "arete/proof/incoherence.h"
#include "arete/proof/papers/published.h"
#include "arete/proof/papers/smart_out_of_core.h"

namespace arete::proof::smart {
namespace {

constexpr int kWidth = 800, kHeight = 600;
constexpr std::array kTolerances{1.0, 2.0, 4.0, 8.0};
constexpr std::array kIncoherences{0.61, 1.36, 5.29};
constexpr int kStretches = 10;
constexpr double kPageBytes = 4096;
// The first pass reads the pages and is what is counted; of the others each frame's quickest is its
// time, so that neither method waits for the disk or for memory that it had not had yet.
constexpr int kPasses = 4;

using Clock = std::chrono::steady_clock;

struct Setting {
  double tolerance_px, incoherence_percent;
  std::string text() const {
    return fmt::format("tolerance={:g}px incoherence={:g}%", tolerance_px, incoherence_percent);
  }
};

/// A frame of a flight: where, and whether the eye was carried there (then it is not counted).
struct Station {
  View view;
  bool teleport;
};

struct FrameCost {
  double ms = 0;
  double sent_bytes = 0;  ///< vertices and indices that a renderer does not have yet
  RefineStats stats;
};

double sent_bytes(const DrawList& list) {
  std::size_t bytes = list.vertices.size() * sizeof(Vertex) +  //
                      list.indices.size() * sizeof(std::uint32_t);
  for (const Upload& u : list.uploads)
    bytes += u.count * (u.kind == BlockKind::Vertices ? sizeof(Vertex) : sizeof(std::uint32_t));
  return static_cast<double>(bytes);
}

/// What one engine spent on every counted frame.
using Costs = std::vector<FrameCost>;

/// The shares or ratios of two runs, a frame each.
struct Ratios {
  std::vector<double> values;
  double of_sums = 0;
  double median() const { return at(0.5); }
  double max() const { return at(1); }

 private:
  double at(double share) const {
    if (values.empty()) return 0;
    std::vector<double> sorted = values;
    const auto k = static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1));
    std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(k));
    return sorted[k];
  }
};

template <typename Quantity>
Ratios ratios(const Costs& over, const Costs& under, Quantity quantity) {
  Ratios out;
  double sum_over = 0, sum_under = 0;
  for (std::size_t i = 0; i < over.size(); ++i) {
    const auto a = static_cast<double>(quantity(over[i]));
    const auto b = static_cast<double>(quantity(under[i]));
    sum_over += a;
    sum_under += b;
    if (b > 0) out.values.push_back(a / b);
  }
  out.of_sums = sum_under > 0 ? sum_over / sum_under : 0;
  return out;
}

class Protocol {
 public:
  Protocol(const store::Terrain& terrain, const scene::Path& path, const PaperOptions& options)
      : terrain_(terrain), path_(path), options_(options) {}

  std::vector<PaperRow> run() {
    for (const double tolerance : kTolerances) {
      for (const double incoherence : kIncoherences) measure({tolerance, incoherence});
    }
    fly_out_of_core();
    return std::move(rows_);
  }

 private:
  // `part`: of the setting that runs, 0..1. Flying out of core counts as one of them.
  void say(std::string_view what, double part = 0) const {
    constexpr double kAll = kTolerances.size() * kIncoherences.size() + 1;
    if (options_.progress) options_.progress(what, (settings_done_ + part) / kAll);
  }

  View view_at(double t) const {
    const double end = path_.duration();
    return make_view(path_.at(path_.closed() ? std::fmod(t, end) : std::min(t, end)), kWidth,
                     kHeight);
  }

  // Mean share of SOAR's triangles that a step of so many seconds changes, along the path.
  double incoherence(lod::Engine& soar, const lod::RefineOptions& refine, double step) const {
    constexpr int kPairs = 24;
    double sum = 0;
    DrawList list;
    for (int i = 0; i < kPairs; ++i) {
      const double t = path_.duration() * (i + 0.5) / kPairs;
      Incoherence pair;
      for (const double at : {t, t + step}) {
        soar.refine(view_at(at), refine, list);
        pair.add(list, soar);
      }
      sum += pair.percent();
    }
    return sum / kPairs;
  }

  // Seconds a frame that reach the incoherence: it grows with the step, so bisect its logarithm.
  double step_for(const Setting& setting, const lod::RefineOptions& refine) const {
    const auto soar = lod::find_engine("soar").open(terrain_, {});
    double low = 1e-6 * path_.duration(), high = 0.1 * path_.duration();
    for (int i = 0; i < 14; ++i) {
      const double middle = std::sqrt(low * high);
      const bool slow = incoherence(*soar, refine, middle) < setting.incoherence_percent;
      (slow ? low : high) = middle;
    }
    return std::sqrt(low * high);
  }

  std::vector<Station> stations(double step) const {
    std::vector<Station> out;
    const int each = std::max(1, options_.frames / kStretches);
    for (int s = 0; s < kStretches; ++s) {
      const double start = path_.duration() * s / kStretches;
      for (int i = 0; i <= each; ++i) out.push_back({view_at(start + i * step), i == 0});
    }
    return out;
  }

  double reached_incoherence(const std::vector<Station>& flight,
                             const lod::RefineOptions& refine) const {
    const auto soar = lod::find_engine("soar").open(terrain_, {});
    Incoherence changes;
    DrawList list;
    double sum = 0;
    int counted = 0;
    for (const Station& station : flight) {
      soar->refine(station.view, refine, list);
      const double percent = changes.add(list, *soar);
      if (station.teleport) continue;
      sum += percent;
      ++counted;
    }
    return counted == 0 ? 0 : sum / counted;
  }

  // The flight's own frames change less or more than the pairs did: once more, in proportion.
  std::vector<Station> flight_for(const Setting& setting, const lod::RefineOptions& refine) const {
    const double step = step_for(setting, refine);
    const double reached = reached_incoherence(stations(step), refine);
    return stations(reached > 0 ? step * setting.incoherence_percent / reached : step);
  }

  Costs fly(std::string_view method, const lod::Params& params, const std::vector<Station>& flight,
            const lod::RefineOptions& refine) const {
    Costs best;
    const auto engine = lod::find_engine(method).open(terrain_, params);
    for (int pass = 0; pass < kPasses; ++pass) {
      DrawList list;
      std::size_t frame = 0;
      for (const Station& station : flight) {
        const auto start = Clock::now();
        engine->refine(station.view, refine, list);
        const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
        if (station.teleport) continue;
        if (pass == 0) {
          best.push_back({std::numeric_limits<double>::infinity(), sent_bytes(list), list.stats});
        } else {
          best[frame].ms = std::min(best[frame].ms, ms);
          ++frame;
        }
      }
    }
    return best;
  }

  void add(std::string_view table, std::string_view quantity, std::optional<double> measured,
           std::string_view unit, std::string_view note = "") {
    rows_.push_back({std::string(table), std::string(quantity), setting_,
                     published("smart", quantity, setting_), measured, std::string(unit),
                     std::string(note)});
  }

  void add_spread(std::string_view table, const std::string& quantity, const Ratios& r,
                  double factor, std::string_view unit) {
    add(table, quantity, factor * r.median(), unit);
    add(table, quantity + "_mean", factor * r.of_sums, unit);
    add(table, quantity + "_max", factor * r.max(), unit);
  }

  // Figure 8: the share of evaluations along the route, a value a stretch.
  void add_route(const Ratios& share) {
    const std::size_t each = std::max<std::size_t>(1, share.values.size() / kStretches);
    for (std::size_t s = 0; s * each < share.values.size() && s < kStretches; ++s) {
      Ratios part;
      part.values.assign(share.values.begin() + static_cast<std::ptrdiff_t>(s * each),
                         share.values.begin() + static_cast<std::ptrdiff_t>(
                                                    std::min((s + 1) * each, share.values.size())));
      add("Figure 8", fmt::format("evaluation_share_percent_route_{:02}", 10 * s),
          100 * part.median(), "%");
    }
  }

  // Pages of records: what out-of-core access costs. Bytes to the GPU: SMART + Cache sends indices
  // and new vertices, SOAR everything.
  void add_traffic(const Costs& soar, const Costs& mine, const std::string& suffix) {
    const auto touched = [](const FrameCost& c) { return c.stats.pages_touched; };
    const auto sent = [](const FrameCost& c) { return c.sent_bytes; };
    add_spread("", "page_touch_share_percent" + suffix, ratios(mine, soar, touched), 100, "%");
    add_spread("", "upload_share_percent" + suffix, ratios(mine, soar, sent), 100, "%");
    const auto total = [](const Costs& costs, auto quantity) {
      double sum = 0;
      for (const FrameCost& c : costs) sum += static_cast<double>(quantity(c));
      return sum;
    };
    const auto faults = [](const FrameCost& c) { return c.stats.pages_read; };
    add("", "page_faults" + suffix, total(mine, faults), "pages", "of the flight, first pass");
    add("", "bytes_read" + suffix, kPageBytes * total(mine, faults), "bytes", "decoded pages");
    if (!suffix.empty()) return;
    add("", "page_faults_soar", total(soar, faults), "pages", "of the flight, first pass");
    add("", "bytes_read_soar", kPageBytes * total(soar, faults), "bytes", "decoded pages");
  }

  void add_comparison(const Costs& soar, const Costs& mine, const std::string& suffix) {
    const auto evaluated = [](const FrameCost& c) { return c.stats.evaluated_vertices; };
    const auto visited = [](const FrameCost& c) { return c.stats.visited_nodes; };
    const auto ms = [](const FrameCost& c) { return c.ms; };
    const Ratios share = ratios(mine, soar, evaluated);
    add_spread("Figure 8", "evaluation_share_percent" + suffix, share, 100, "%");
    add_spread("Figure 8", "visited_share_percent" + suffix, ratios(mine, soar, visited), 100, "%");
    add_spread("Figures 9, 10", "mesh_speedup" + suffix, ratios(soar, mine, ms), 1, "x");
    add_traffic(soar, mine, suffix);
    if (suffix.empty()) add_route(share);
  }

  void measure(const Setting& setting) {
    setting_ = setting.text();
    say(setting_);
    // The paper's alpha = m / phi (eq. 1) is an angle; our default bounds pixels instead.
    lod::RefineOptions refine;
    refine.tolerance_px = setting.tolerance_px;
    refine.scale = ErrorScale::Angular;
    const std::vector<Station> flight = flight_for(setting, refine);
    const Costs soar = fly("soar", {}, flight, refine);
    add_comparison(soar, fly("smart", {}, flight, refine), "");
    const lod::Params ceil{{"literal", "true"}, {"ticks", "ceil"}};
    add_comparison(soar, fly("smart", ceil, flight, refine), "_literal");
    refine.scale = ErrorScale::Upright;
    add_comparison(fly("soar", {}, flight, refine), fly("smart", {}, flight, refine), "_upright");
    refine.scale = ErrorScale::Angular;
    add("", "incoherence_percent", reached_incoherence(flight, refine), "%",
        "of SOAR's triangles, mean of the counted frames");
    add("Figures 9, 10", "total_speedup", std::nullopt, "x", "a claim on a GPU only");
    settings_done_ += 1;
  }

  // Without a teleport but the first frame, at the quickest of the speeds.
  void fly_out_of_core() {
    const Setting setting{1, kIncoherences.back()};
    say("out of core: " + setting.text());
    const double step = step_for(setting, {.tolerance_px = setting.tolerance_px});
    LateSetting late{setting.text(), setting.tolerance_px, {}};
    for (int i = 0; i < options_.frames; ++i) late.flight.push_back(view_at(i * step));
    const Progress progress = [this](std::string_view what, double part) { say(what, part); };
    std::ranges::move(out_of_core(terrain_, late, progress), std::back_inserter(rows_));
  }

  const store::Terrain& terrain_;
  const scene::Path& path_;
  const PaperOptions& options_;
  std::vector<PaperRow> rows_;
  std::string setting_;
  double settings_done_ = 0;
};

}  // namespace

std::vector<PaperRow> run(const store::Terrain& terrain, const scene::Path& path,
                          const PaperOptions& options) {
  return Protocol(terrain, path, options).run();
}

}  // namespace arete::proof::smart
