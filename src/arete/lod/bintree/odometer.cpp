#include "arete/lod/bintree/odometer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arete::lod::bintree {
namespace {

constexpr double kTurnTick = 1e-7;       // radians
constexpr double kScaleTick = 1e-6;      // of nu at a restart
constexpr double kMostScaleTick = 1e-4;  // of nu: where it has shrunk by more, a restart is due

// Offset of a plane from the eye.
double offset(const glm::dvec4& plane, glm::dvec3 eye) {
  return glm::dot(glm::dvec3(plane), eye) + plane.w;
}

}  // namespace

Odometer::Odometer(double move_tick_m, Rounding rounding)
    : tick_{move_tick_m, 1, kTurnTick}, rounding_(rounding) {}

// |height'(v) - height(v)| <= |dP| + |d offset| + |n' - n| |P - v| for each plane.
Allowance Odometer::step_to(const Criterion& next) const {
  double turn = 0;
  double slide = 0;
  for (std::size_t i = 0; i < planes_.size(); ++i) {
    const glm::dvec4& n = next.planes()[i];
    turn = std::max(turn, glm::length(glm::dvec3(n) - glm::dvec3(planes_[i])));
    slide = std::max(slide, std::abs(offset(n, next.eye()) - offset(planes_[i], eye_)));
  }
  const double moved = glm::length(next.eye() - eye_);
  return {moved + slide, std::abs(next.nu() - nu_), turn};
}

void Odometer::add(std::size_t clock, double step) {
  if (step == 0) return;
  double& total = total_[clock];
  const double tick = tick_[clock];
  if (rounding_ == Rounding::Floor && clock == Move) {
    total += tick * std::floor(step / tick);
  } else if (rounding_ == Rounding::Ceil && clock == Move) {
    total += tick * std::ceil(step / tick);
  } else {  // never less than was travelled, however the sum rounds
    total = std::nextafter(total + step, std::numeric_limits<double>::infinity());
  }
}

bool Odometer::advance(const Criterion& next) {
  constexpr double kForget = 0.25;
  const Allowance step = started_ ? step_to(next) : Allowance{};
  bool holds = started_ && floor_ == next.floor_m() && tick_[Scale] < kMostScaleTick * next.nu();
  holds = holds && (rounding_ == Rounding::Exact || step[Scale] == 0);  // the paper has no clock
  for (std::size_t k = 0; k < kClocks; ++k) {
    add(k, step[k]);
    rates_[k] += kForget * (step[k] - rates_[k]);
    holds = holds && total_[k] / tick_[k] < kMostTicks;
  }
  turned_ = step[Turn] > 0;
  planes_ = next.planes();
  eye_ = next.eye();
  nu_ = next.nu();
  floor_ = next.floor_m();
  started_ = true;
  if (!holds) restart();
  read(step);
  return holds;
}

void Odometer::restart() {
  total_ = {};
  now_.fill(1);  // no status lasts until 0 or 1
  tick_[Scale] = kScaleTick * nu_;
  for (std::size_t k = 0; k < kClocks; ++k) per_tick_[k] = 1 / tick_[k];
}

// The least whole number of ticks that is not behind, and one more for whatever moved. The total
// goes along: else ranges to come would be measured from ever further behind.
void Odometer::read(const Allowance& step) {
  for (std::size_t k = 0; k < kClocks; ++k) {
    const auto ticks = static_cast<Tick>(std::ceil(total_[k] * per_tick_[k] + kQuotientRounding));
    const bool counts = step[k] > 0 && (rounding_ == Rounding::Exact || k != Move);
    now_[k] = std::max(ticks, now_[k] + (counts ? 1 : 0));
    if (now_[k] > ticks) total_[k] = (now_[k] - 2 * kQuotientRounding) * tick_[k];
    travelled_[k] = total_[k] * per_tick_[k] - kQuotientRounding;
  }
}

Ticks Odometer::before(const Ticks& until, double frames) const {
  Ticks out = until;
  for (std::size_t k = 0; k < kClocks; ++k) {
    if (until[k] == kForever) continue;
    const double lead = std::min(frames * rates_[k] * per_tick_[k], kMostTicks);
    out[k] = std::max(until[k] - static_cast<Tick>(lead), 0);
  }
  return out;
}

}  // namespace arete::lod::bintree
