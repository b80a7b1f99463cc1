#include "arete/lod/bintree/live_range.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arete::lod::bintree {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// Part of a distance to give to the first of two clocks, so that both are expected to run out
// together; never all of it, for rates change.
double share(double first, double second) {
  constexpr double kLeast = 1.0 / 16;
  return first + second > 0 ? std::clamp(first / (first + second), kLeast, 1 - kLeast) : 0.5;
}

Allowance least(const Allowance& a, const Allowance& b) {
  return {std::min(a[Move], b[Move]), std::min(a[Scale], b[Scale]), std::min(a[Turn], b[Turn])};
}

}  // namespace

// |d(d_tau)| <= |dP| + delta |dnu| [METHODS 8.6]. Deviation: with the vertex's own delta, where
// 8.6 has a clock a depth with the largest delta there.
Allowance Evaluation::selection_allowance(const Ball& ball, double distance) const {
  const double reach = criterion_.reach(ball);
  if (ball.delta <= criterion_.floor_m() || std::isinf(reach)) return {kNever, kNever, kNever};
  const double gap =
      std::abs(reach - distance) - Criterion::slack(ball) - 1e-9 * (distance + reach);
  const Allowance& rates = odometer_.rates();
  const double part = share(rates[Move], ball.delta * rates[Scale]);
  return {part * gap, (1 - part) * gap / ball.delta, kNever};
}

// d_c = min (r - d_i) [BaoPajarolaShafae2004, eq. 8]; a plane's distance changes by at most
// |dP| + |P - v| dtheta [METHODS 8.5b].
Allowance Evaluation::culling_allowance(const Ball& ball, double margin, double distance) const {
  if (!options_.culling) return {kNever, kNever, kNever};
  const double gap = std::abs(margin) - Criterion::slack(ball) - 1e-9 * distance;
  const Allowance& rates = odometer_.rates();
  const double part = share(rates[Move], distance * rates[Turn]);
  return {part * gap, kNever, (1 - part) * gap / (distance + std::max(part * gap, 0.0))};
}

// Frames that an allowance is expected to last.
double Evaluation::frames(const Allowance& allowance) const {
  double least = kNever;
  for (std::size_t k = 0; k < kClocks; ++k) {
    const double rate = odometer_.rates()[k];
    if (rate > 0) least = std::min(least, allowance[k] / rate);
  }
  return least;
}

// An active status needs both parts, any other one that fails [METHODS 8.4].
Allowance Evaluation::allowance(const Ball& ball, const LiveVertex& vertex, double margin,
                                double distance) const {
  if (options_.safe == SafeDistance::Least) {
    const double planes = options_.culling ? std::abs(margin) : kNever;
    return {std::min(std::abs(criterion_.reach(ball) - distance), planes), kNever, kNever};
  }
  if (!vertex.selected && vertex.visible) return selection_allowance(ball, distance);
  const Allowance culling = culling_allowance(ball, margin, distance);
  if (vertex.selected && !vertex.visible) return culling;
  const Allowance selection = selection_allowance(ball, distance);
  if (vertex.selected) return least(selection, culling);
  return frames(selection) > frames(culling) ? selection : culling;
}

void Evaluation::operator()(const Ball& ball, LiveVertex& vertex) const {
  const double lowest = options_.culling ? criterion_.lowest(ball) : kNever;
  const double squared = criterion_.squared(ball);
  vertex.selected = criterion_.selected(ball, squared);
  vertex.visible = !(lowest < -ball.radius);
  vertex.inside = lowest >= ball.radius;
  vertex.until = odometer_.until(allowance(ball, vertex, lowest + ball.radius, std::sqrt(squared)));
}

}  // namespace arete::lod::bintree
