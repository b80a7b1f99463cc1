#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "arete/lod/bintree/criterion.h"

namespace arete::lod::bintree {

/// What moves a vertex towards a change of its status. Each only ever grows.
enum Clock : int {
  Move,   ///< O = sum |dP|, metres [BaoPajarolaShafae2004, eq. 7, 9]
  Scale,  ///< V = sum |d nu|: tolerance, pitch, field of view, viewport [METHODS 8.6]
  Turn,   ///< R = sum of the largest turn of a frustum plane, radians [METHODS 8.5]
};
inline constexpr std::size_t kClocks = 3;

/// Ticks of each clock: readings, or what readings a status outlives.
using Tick = std::int32_t;
using Ticks = std::array<Tick, kClocks>;
inline constexpr Tick kForever = std::numeric_limits<Tick>::max();

/// True while every reading is below its limit: an integer test a clock.
inline bool alive(const Ticks& now, const Ticks& until) {
  return now[Move] < until[Move] && now[Scale] < until[Scale] && now[Turn] < until[Turn];
}

/// How far a status may be carried on each clock.
using Allowance = std::array<double, kClocks>;

/// How ticks are counted from motion.
enum class Rounding {
  Exact,  ///< sums in double, rounded up; ticks only then [METHODS 8.3]
  Ceil,   ///< every frame's step up to whole ticks
  Floor,  ///< every frame's step down: eq. 12 as printed, which is unsafe
};

/// The exact odometers of a flight: a status with allowance d_k on each clock, read at this frame,
/// holds as long as alive(now(), until(d)) says so.
/// Proof: f >= X / S, and alive means f < L. Where L <= (X0 + d) / S, X < X0 + d. Else L = f0 + 1,
/// so f = f0: it rises with every motion, so there was none.
class Odometer {
 public:
  /// `move_tick_m`: S_min of the paper, metres; it decides how early a range ends, not whether it
  /// is right.
  Odometer(double move_tick_m, Rounding rounding);

  /// Goes on to the next frame. False when the ranges given so far are void: the first frame, after
  /// a change that no clock measures, and every 2^30 ticks.
  bool advance(const Criterion& criterion);
  const Ticks& now() const { return now_; }
  Ticks until(const Allowance& allowance) const {
    Ticks out;
    for (std::size_t k = 0; k < kClocks; ++k) out[k] = until(k, allowance[k]);
    return out;
  }
  /// What `until` is expected to be so many frames before.
  Ticks before(const Ticks& until, double frames) const;
  /// Smoothed steps of the clocks: what the next frames may be expected to take.
  const Allowance& rates() const { return rates_; }
  /// The planes turned in this frame.
  bool turned() const { return turned_; }

 private:
  /// More ticks than a number of them below kMostTicks is rounded by.
  static constexpr double kQuotientRounding = 1e-5;
  static constexpr double kMostTicks = 0x1p30;

  // L = floor((X0 + d) / S); or to the next motion, where d is less than that.
  Tick until(std::size_t k, double allowance) const {
    const double ticks = travelled_[k] + allowance * per_tick_[k];
    if (!(ticks < 2 * kMostTicks - 1)) return kForever;
    const auto whole = static_cast<Tick>(std::max(ticks, 0.0));
    const bool counts_motions = rounding_ == Rounding::Exact || k != Move;
    return counts_motions ? std::max(whole, now_[k] + 1) : whole;
  }
  Allowance step_to(const Criterion& next) const;
  void add(std::size_t clock, double step);
  void restart();
  void read(const Allowance& step);

  Allowance tick_, per_tick_{};
  Rounding rounding_;
  Allowance total_{}, rates_{};
  Allowance travelled_{};  ///< the total in ticks, no more than that
  Ticks now_{};
  std::array<glm::dvec4, Criterion::kPlanes> planes_{};
  glm::dvec3 eye_{0};
  double nu_ = 0, floor_ = 0;
  bool started_ = false, turned_ = false;
};

}  // namespace arete::lod::bintree
