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
  if (ball.delta <= criterion_.floor_m()) return {kNever, kNever, kNever};
  const double reach = criterion_.reach(ball);
  const double gap =
      std::abs(reach - distance) - Criterion::slack(ball) - 1e-9 * (distance + reach);
  if (std::isinf(gap)) return {kNever, kNever, kNever};
  const Allowance& rates = odometer_.rates();
  const double part = share(rates[Move], ball.delta * rates[Scale]);
  return {part * gap, (1 - part) * gap / ball.delta, kNever};
}

// A plane's distance changes by at most |dP| + |P - v| dtheta [METHODS 8.5b].
Allowance Evaluation::culling_allowance(const Ball& ball, double distance) const {
  if (!options_.culling) return {kNever, kNever, kNever};
  const double gap = std::abs(criterion_.margin(ball)) - Criterion::slack(ball) - 1e-9 * distance;
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

void Evaluation::operator()(const Ball& ball, LiveVertex& vertex) const {
  const double distance = glm::length(ball.centre - criterion_.eye());
  vertex.selected = criterion_.selected(ball);
  vertex.visible = !options_.culling || criterion_.visible(ball);
  const Allowance selection = selection_allowance(ball, distance);
  const Allowance culling = culling_allowance(ball, distance);
  Allowance lasts;
  if (options_.safe == SafeDistance::Least) {
    lasts = {std::min(std::abs(criterion_.reach(ball) - distance),
                      options_.culling ? std::abs(criterion_.margin(ball)) : kNever),
             kNever, kNever};
  } else if (vertex.selected && vertex.visible) {
    lasts = least(selection, culling);
  } else if (vertex.selected) {
    lasts = culling;
  } else if (vertex.visible) {
    lasts = selection;
  } else {
    lasts = frames(selection) > frames(culling) ? selection : culling;
  }
  vertex.until = odometer_.until(lasts);
}

}  // namespace arete::lod::bintree
