#include "arete/lod/least_fitting.h"

#include <algorithm>
#include <cmath>

namespace arete::lod {
namespace {

// An end of the bracket. The excess is weighed as the Illinois method wants it: halved for an end
// that stays twice, or the other end would creep.
struct End {
  double x, excess;
};

// Where the line between the ends crosses 0, but at least half a step from either: once the
// crossing is found from one side, the other side is brought to it in one call.
double next(const End& lo, const End& hi) {
  const double crossing =
      lo.x + (hi.x - lo.x) * lo.excess / std::max(lo.excess - hi.excess, 1e-300);
  return std::clamp(crossing, lo.x + kFitStep / 2, hi.x - kFitStep / 2);
}

// Steps out until something fits. False: nothing does.
bool bracket(const std::function<double(double)>& excess, End& lo, End& hi) {
  hi = lo;
  for (double step = 1.25; hi.excess > 0; step *= 2) {
    if (hi.x >= kMostCoarse) return false;
    lo = hi;
    hi.x = std::min(lo.x + std::max(lo.excess * step, 4 * kFitStep), kMostCoarse);
    hi.excess = excess(hi.x);
  }
  return true;
}

double ratio(std::uint64_t need, std::uint64_t cap) {
  return static_cast<double>(need) / static_cast<double>(std::max<std::uint64_t>(cap, 1));
}

}  // namespace

double excess(const Budget& need, const Budget& cap) {
  return std::log(std::max(
      {ratio(need.triangles, cap.triangles), ratio(need.vertex_bytes, cap.vertex_bytes), 1e-300}));
}

double least_fitting(const std::function<double(double)>& excess) {
  End lo{0, excess(0)};
  End hi = lo;
  if (lo.excess <= 0) return 0;
  if (!bracket(excess, lo, hi)) return kMostCoarse;
  double last = hi.x;
  bool low_moved = false;
  bool high_moved = false;
  for (int calls = 0; hi.x - lo.x > kFitStep; ++calls) {
    // Excess falls in steps: should the line mislead for long, halves cannot.
    last = calls < 12 ? next(lo, hi) : (lo.x + hi.x) / 2;
    const double found = excess(last);
    if (found > 0) {
      lo = {last, found};
      if (low_moved) hi.excess /= 2;
      low_moved = true;
      high_moved = false;
    } else {
      hi = {last, found};
      if (high_moved) lo.excess /= 2;
      high_moved = true;
      low_moved = false;
    }
  }
  if (last != hi.x) excess(hi.x);
  return hi.x;
}

}  // namespace arete::lod
