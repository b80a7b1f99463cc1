#include "arete/proof/late_flight.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>

#include <unistd.h>

#include "arete/proof/residual.h"
#include "arete/proof/verify.h"

namespace arete::proof {
namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

void count_late(const RefineStats& stats, LateFlight& out) {
  const bool cold = out.cold_frames == out.frames;
  (cold ? out.cold_late_vertices : out.late_vertices) += stats.late_blocks;
  if (stats.late_blocks > 0) ++(cold ? out.cold_frames : out.late_frames);
}

void add(const RefineStats& stats, double ms, LateFlight& out) {
  count_late(stats, out);
  out.pages_touched_max = std::max(out.pages_touched_max, stats.pages_touched);
  out.page_bytes_max = std::max(out.page_bytes_max, stats.page_bytes);
  out.pages_waited_for += stats.pages_read;
  out.worst_ms = std::max(out.worst_ms, ms);
  const std::uint64_t held = process_bytes();
  if (out.frames == 0) out.process_bytes_first = held;
  out.process_bytes_max = std::max(out.process_bytes_max, held);
  ++out.frames;
}

// At most `most` of the frames that were late, evenly taken.
std::vector<const DrawnFrame*> some_late(std::span<const DrawnFrame> frames, int most) {
  std::vector<const DrawnFrame*> late;
  for (const DrawnFrame& frame : frames)
    if (frame.stats.late_blocks > 0) late.push_back(&frame);
  const auto all = late.size();
  const std::size_t n = std::min(all, static_cast<std::size_t>(most));
  for (std::size_t i = 0; i < n; ++i) late[i] = late[i * all / n];
  late.resize(n);
  return late;
}

void measure(const DrawnFrame& frame, const Reference& reference, int threads, FrameChecks& out) {
  const double claimed = frame.stats.achieved_error_px;
  if (!std::isfinite(claimed)) {
    ++out.unbounded;
    return;
  }
  const double px = measure_residuals(frame.surface, reference, frame.view, threads).px.max_px();
  ++out.measured;
  out.worst_px = std::max(out.worst_px, px);
  out.claimed_px = std::max(out.claimed_px, claimed);
  out.worst_claim_share =
      std::max(out.worst_claim_share, std::max(0.0, px - kRoundingPx) / claimed);
}

}  // namespace

LateFlight fly_late(lod::Engine& engine, std::span<const View> flight,
                    const lod::RefineOptions& refine, double frame_ms, const SeeFrame& see) {
  LateFlight out;
  DrawList list;
  for (const View& view : flight) {
    const auto start = Clock::now();
    engine.refine(view, refine, list);
    const Milliseconds taken = Clock::now() - start;
    add(list.stats, taken.count(), out);
    if (see) see(view, list);
    std::this_thread::sleep_until(
        start + std::chrono::duration_cast<Clock::duration>(Milliseconds(frame_ms)));
  }
  return out;
}

std::vector<DrawnFrame> keep_late(lod::Engine& engine, std::span<const View> flight,
                                  const lod::RefineOptions& refine, double frame_ms,
                                  const std::function<void()>& kept) {
  std::vector<DrawnFrame> frames;
  frames.reserve(flight.size());
  fly_late(engine, flight, refine, frame_ms, [&](const View& view, const DrawList& list) {
    frames.push_back({view, {}, list.stats});
    mesh::flatten(list, engine, frames.back().surface);
    if (kept) kept();
  });
  return frames;
}

FrameChecks check_late(std::span<const DrawnFrame> frames, const Reference& reference,
                       int most_measured, int threads, const std::function<void()>& checked) {
  FrameChecks out;
  for (const DrawnFrame& frame : frames) {
    const mesh::SurfaceReport report =
        mesh::check_surface(frame.surface, reference.dem(), &frame.view, threads);
    out.cracks += report.cracks() + report.t_junctions;
    if (checked) checked();
  }
  for (const DrawnFrame* frame : some_late(frames, most_measured)) {
    measure(*frame, reference, threads, out);
    if (checked) checked();
  }
  return out;
}

std::uint64_t process_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t whole = 0, resident = 0;
  statm >> whole >> resident;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace arete::proof
