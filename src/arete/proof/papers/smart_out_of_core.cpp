#include "arete/proof/papers/smart_out_of_core.h"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "arete/proof/late_flight.h"

namespace arete::proof::smart {
namespace {

constexpr std::uint64_t kPageBytes = 4096;
constexpr std::uint64_t kStoredShare = 8;  // the budget is at most one in so many pages
constexpr double kFrameMs = 8;
constexpr int kThreads = 2, kMostMeasured = 60;
constexpr const char* kSegment = "bintree";

/// A method and how it is opened.
struct Flyer {
  std::string_view method, suffix;
  lod::Params params;
};

/// What one flyer did: while nothing but time was taken, under Wait, and as checked.
struct Outcome {
  LateFlight deferred, waited;
  FrameChecks checks;
};

class OutOfCore {
 public:
  OutOfCore(const store::Terrain& terrain, const LateSetting& setting, const Progress& progress)
      : terrain_(terrain), setting_(setting), progress_(progress) {}

  std::vector<PaperRow> run() {
    count_pages();
    if (const std::string why = why_not(); !why.empty()) {
      setting_text_ = setting_.text;
      add("page_budget_bytes", std::nullopt, "bytes", why);
      return std::move(rows_);
    }
    choose_budget();
    add_pages();
    const std::string pages = std::to_string(budget_pages_);
    const std::array<Flyer, 3> flyers{
        {{"smart", "", {{"pages", pages}}},
         {"smart", "_no_prefetch", {{"pages", pages}, {"prefetch", "off"}}},
         {"soar", "_soar", {{"pages", pages}}}}};
    std::array<Outcome, flyers.size()> outcomes;
    for (std::size_t i = 0; i < flyers.size(); ++i) fly(flyers[i], outcomes[i]);
    begin("heights", 1);
    const auto source = terrain_.height_source();
    const Heightfield dem(*source);  // after the flights: it would hide what they hold
    const Reference reference(dem, kThreads);
    for (std::size_t i = 0; i < flyers.size(); ++i) {
      check(flyers[i], reference, outcomes[i]);
      add(std::string(flyers[i].suffix), outcomes[i]);
    }
    return std::move(rows_);
  }

 private:
  // A step of the part that takes so many calls of tick().
  void begin(std::string what, std::size_t ticks) {
    what_ = "out of core: " + std::move(what);
    ticks_ = ticks;
    ticked_ = 0;
    ++begun_;
    tell();
  }

  void tick() {
    ticked_ = std::min(ticked_ + 1, ticks_);
    tell();
  }

  void tell() const {
    constexpr double kSteps = 8;  // pages, three flyers, heights, their checks
    const double within = static_cast<double>(ticked_) / static_cast<double>(ticks_);
    if (progress_) progress_(what_, (begun_ - 1 + within) / kSteps);
  }

  SeeFrame ticking() {
    return [this](const View&, const DrawList&) { tick(); };
  }

  void count_pages() {
    begin("pages of the flight", setting_.flight.size());
    const auto soar = lod::find_engine("soar").open(terrain_, {});
    const LateFlight whole =
        fly_late(*soar, setting_.flight, refine(lod::OnMissing::Wait), 0, ticking());
    stored_pages_ = terrain_.keys(kSegment).size() - 1;  // the last block is none
    flight_pages_ = whole.pages_waited_for;
    frame_pages_ = whole.pages_touched_max;
  }

  // Why no budget shows anything; empty when one does.
  std::string why_not() const {
    if (2 * frame_pages_ > stored_pages_ / kStoredShare)
      return fmt::format(
          "not flown: two frames touch up to {} pages, more than an eighth of the {} stored: take "
          "a larger terrain",
          2 * frame_pages_, stored_pages_);
    if (2 * frame_pages_ >= flight_pages_)
      return fmt::format(
          "not flown: two frames touch up to {} pages, the whole flight {}: no budget for the one "
          "binds in the other: fly more frames",
          2 * frame_pages_, flight_pages_);
    return {};
  }

  // Half of what the flight touches, so that the budget binds, but not less than two frames hold on
  // to; and not more than an eighth of all, which why_not() has compared with two frames.
  void choose_budget() {
    budget_pages_ = std::min(std::max({flight_pages_ / 2, 2 * frame_pages_, std::uint64_t{1}}),
                             stored_pages_ / kStoredShare);
    setting_text_ = fmt::format("{} pages={}", setting_.text, budget_pages_);
  }

  void add_pages() {
    const auto bytes = [](std::uint64_t pages) { return static_cast<double>(pages * kPageBytes); };
    add("page_bytes_stored", bytes(stored_pages_), "bytes", "decoded");
    add("page_bytes_of_flight", bytes(flight_pages_), "bytes", "that it touches");
    add("page_bytes_of_frame", bytes(frame_pages_), "bytes", "of soar, at most");
    add("page_budget_bytes", bytes(budget_pages_), "bytes", "hard");
    add("stored_to_budget", bytes(stored_pages_) / bytes(budget_pages_), "x");
  }

  lod::RefineOptions refine(lod::OnMissing on_missing) const {
    return {.tolerance_px = setting_.tolerance_px, .on_missing = on_missing};
  }

  std::unique_ptr<lod::Engine> open_cold(const Flyer& flyer) const {
    auto engine = lod::find_engine(flyer.method).open(terrain_, flyer.params);
    terrain_.drop_os_cache();
    return engine;
  }

  void fly(const Flyer& flyer, Outcome& out) {
    begin(fmt::format("{}{}", flyer.method, flyer.suffix), 2 * setting_.flight.size());
    out.deferred = fly_late(*open_cold(flyer), setting_.flight, refine(lod::OnMissing::Defer),
                            kFrameMs, ticking());
    out.waited = fly_late(*open_cold(flyer), setting_.flight, refine(lod::OnMissing::Wait),
                          kFrameMs, ticking());
  }

  void check(const Flyer& flyer, const Reference& reference, Outcome& out) {
    begin(fmt::format("checks of {}{}", flyer.method, flyer.suffix),
          2 * setting_.flight.size() + kMostMeasured);
    const auto ticking = [this] { tick(); };
    const auto frames = keep_late(*open_cold(flyer), setting_.flight, refine(lod::OnMissing::Defer),
                                  kFrameMs, ticking);
    out.checks = check_late(frames, reference, kMostMeasured, kThreads, ticking);
  }

  void add(const std::string& suffix, const Outcome& out) {
    const auto count = [&](const char* quantity, auto n, const char* unit, const char* note = "") {
      add(quantity + suffix, static_cast<double>(n), unit, note);
    };
    const LateFlight& flown = out.deferred;
    count("cold_frames", flown.cold_frames, "frames",
          "before the first that missed nothing; the OS cache dropped before (posix_fadvise)");
    count("cold_late_vertices", flown.cold_late_vertices, "vertices");
    count("late_frames", flown.late_frames, "frames", "after it");
    count("late_vertices", flown.late_vertices, "vertices", "wanted by a frame and not there");
    count("page_cache_bytes_max", flown.page_bytes_max, "bytes", "sampled every frame");
    count("process_growth_bytes", flown.process_bytes_max - flown.process_bytes_first, "bytes",
          "resident, from the first frame to the most; sampled every frame");
    count("pages_waited_for", flown.pages_waited_for, "pages");
    count("refine_ms_worst_defer", flown.worst_ms, "ms");
    count("refine_ms_worst_wait", out.waited.worst_ms, "ms");
    count("pages_waited_for_wait", out.waited.pages_waited_for, "pages");
    count("cracks", out.checks.cracks, "", "and T-junctions; every frame of another such flight");
    count("late_frames_measured", out.checks.measured, "frames", "of that flight");
    count("late_frames_unbounded", out.checks.unbounded, "frames", "of that flight");
    count("late_error_px_max", out.checks.worst_px, "px");
    count("late_claim_px_max", out.checks.claimed_px, "px", "achieved_error_px");
    count("late_error_to_claim_max", out.checks.worst_claim_share, "", "honest up to 1");
  }

  void add(const std::string& quantity, std::optional<double> measured, const char* unit,
           const std::string& note = "") {
    rows_.push_back({"out of core", quantity, setting_text_, std::nullopt, measured, unit, note});
  }

  const store::Terrain& terrain_;
  const LateSetting& setting_;
  const Progress& progress_;
  std::string what_;
  std::size_t ticks_ = 1, ticked_ = 0;
  int begun_ = 0;
  std::uint64_t stored_pages_ = 0, flight_pages_ = 0, frame_pages_ = 0, budget_pages_ = 1;
  std::string setting_text_;
  std::vector<PaperRow> rows_;
};

}  // namespace

std::vector<PaperRow> out_of_core(const store::Terrain& terrain, const LateSetting& setting,
                                  const Progress& progress) {
  return OutOfCore(terrain, setting, progress).run();
}

}  // namespace arete::proof::smart
