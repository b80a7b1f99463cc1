#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "arete/lod/engine.h"
#include "arete/mesh/surface.h"
#include "arete/proof/reference.h"

namespace arete::proof {

/// What a flight did while records were missing, sampled after every frame.
struct LateFlight {
  int frames = 0;
  int cold_frames = 0;  ///< before the first that missed nothing
  int late_frames = 0;  ///< after it
  std::uint64_t cold_late_vertices = 0, late_vertices = 0;
  std::uint64_t pages_touched_max = 0;  ///< of a frame
  std::uint64_t page_bytes_max = 0;
  std::uint64_t pages_waited_for = 0;  ///< read while a frame waited
  double worst_ms = 0;                 ///< of refine alone
  std::uint64_t process_bytes_first = 0, process_bytes_max = 0;
};

/// Told of every frame after its time was taken; may throw to stop.
using SeeFrame = std::function<void(const View&, const DrawList&)>;

/// Draws the views, `frame_ms` apart as a viewer does: what a frame leaves of that is slept.
LateFlight fly_late(lod::Engine& engine, std::span<const View> flight,
                    const lod::RefineOptions& refine, double frame_ms, const SeeFrame& see = {});

/// A frame as it was drawn, to be checked when nothing waits for the next.
struct DrawnFrame {
  View view;
  mesh::Surface surface;
  RefineStats stats;
};

/// Keeps every frame of fly_late; `kept` is called after each and may throw to stop.
std::vector<DrawnFrame> keep_late(lod::Engine& engine, std::span<const View> flight,
                                  const lod::RefineOptions& refine, double frame_ms,
                                  const std::function<void()>& kept = {});

/// What drawn frames are worth.
struct FrameChecks {
  std::uint64_t cracks = 0;      ///< and T-junctions, of all frames
  int measured = 0;              ///< late frames with a bound, measured at every post in view
  int unbounded = 0;             ///< late frames that claim no bound
  double worst_px = 0;           ///< measured
  double claimed_px = 0;         ///< the largest bound of the measured frames
  double worst_claim_share = 0;  ///< measured error / the frame's own bound; <= 1 is honest
};

/// Checks every frame in integers and holds up to `most_measured` late ones, evenly taken, to their
/// RefineStats::achieved_error_px. `checked` is called after either and may throw to stop.
/// Requires: a scale in pixels, not ErrorScale::Angular.
FrameChecks check_late(std::span<const DrawnFrame> frames, const Reference& reference,
                       int most_measured, int threads, const std::function<void()>& checked = {});

/// Bytes of memory that this process holds; 0 where the system does not say.
std::uint64_t process_bytes();

}  // namespace arete::proof
