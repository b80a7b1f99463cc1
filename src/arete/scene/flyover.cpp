#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "arete/scene/flights.h"

namespace arete::scene {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSeconds = 60;
constexpr double kStep = 0.25;  // between keyframes
constexpr int kKeyframes = static_cast<int>(kSeconds / kStep);
constexpr double kHoverStart = 20.5, kHoverEnd = 23.5;
constexpr double kTurnStart = 21, kTurnEnd = 23;

/// What is wished at a moment; between two of them by smoothstep.
struct Phase {
  double t;
  double low, middle, high;  // shares of the three heights; they add up to 1
  double pitch;              // degrees
  double slow, fast;         // speed: in low speeds, in cruising speeds
};

// Middle height for half of the time, low and high for a quarter each. The hover and the turn lie
// in the low quarter, where the track has its cusp; the climb follows.
constexpr std::array<Phase, 13> kPhases{{{0, 0, 1, 0, -13, 0, 1},
                                         {13, 0, 1, 0, -12, 0, 1},
                                         {15, 1, 0, 0, -7, 1, 0},
                                         {18.5, 1, 0, 0, -7, 1, 0},
                                         {kHoverStart, 1, 0, 0, -6, 0, 0},
                                         {kHoverEnd, 1, 0, 0, -6, 0, 0},
                                         {25.5, 1, 0, 0, -7, 1, 0},
                                         {29, 1, 0, 0, -7, 1, 0},
                                         {31, 0, 1, 0, -11, 0, 1},
                                         {40, 0, 1, 0, -13, 0, 1},
                                         {43, 0, 0, 1, -27, 0, 2.2},
                                         {56, 0, 0, 1, -27, 0, 2.2},
                                         {59, 0, 1, 0, -13, 0, 1}}};

Phase phase_at(double t) {
  std::size_t i = kPhases.size() - 1;
  while (kPhases[i].t > t) --i;
  const Phase& a = kPhases[i];
  const Phase& b = kPhases[(i + 1) % kPhases.size()];
  const double end = b.t > a.t ? b.t : kSeconds;
  const double u = glm::smoothstep(a.t, end, t);
  const auto mix = [u](double x, double y) { return x + (y - x) * u; };
  return {t,
          mix(a.low, b.low),
          mix(a.middle, b.middle),
          mix(a.high, b.high),
          mix(a.pitch, b.pitch),
          mix(a.slow, b.slow),
          mix(a.fast, b.fast)};
}

/// The ground plan: a cardioid over the middle 80 % of the grid. It is closed and smooth but for
/// one cusp, where it comes back on itself: there the camera stops and turns.
class Track {
 public:
  explicit Track(const Ground& ground) : ground_(ground) {
    for (int i = 0; i <= kPieces; ++i) {
      const double piece = i == 0 ? 0 : glm::distance(point(i), point(i - 1));
      length_.push_back((i == 0 ? 0 : length_.back()) + piece);
    }
  }
  double length() const { return length_.back(); }

  /// World point after s metres from the cusp, 0 <= s <= length().
  glm::dvec2 at(double s) const {
    const auto after = std::upper_bound(length_.begin() + 1, length_.end() - 1, s);
    const auto i = static_cast<int>(after - length_.begin());
    const double a = length_[static_cast<std::size_t>(i - 1)];
    const double b = length_[static_cast<std::size_t>(i)];
    const double u = b > a ? std::clamp((s - a) / (b - a), 0.0, 1.0) : 0;
    return plan(i - 1 + u);
  }

 private:
  static constexpr int kPieces = 4096;
  glm::dvec2 point(int i) const { return plan(i); }

  // (1 - cos a) (cos a, sin a) spans [-2, 1/4] x [-1.3, 1.3].
  glm::dvec2 plan(double piece) const {
    const double a = 2 * kPi * piece / kPieces;
    const double r = 1 - std::cos(a);
    const double u = (r * std::cos(a) + 0.875) / 1.125;
    const double v = r * std::sin(a) / 1.299038105676658;
    const double half_cols = 0.4 * std::max(ground_.cols - 1, 1);
    const double half_rows = 0.4 * std::max(ground_.rows - 1, 1);
    return ground_.world_from_post.apply((ground_.cols - 1) * 0.5 + half_cols * u,
                                         (ground_.rows - 1) * 0.5 + half_rows * v);
  }

  const Ground& ground_;
  std::vector<double> length_;  // from the cusp to each point
};

/// Distance along the track by time: slow and low around the cusp, the rest spread over the minute.
class Schedule {
 public:
  Schedule(double length, double spacing) : length_(length) {
    std::vector<double> slow{0}, fast{0};
    for (int i = 0; i < kTicks; ++i) {
      const Phase p = phase_at((i + 0.5) * kTick);
      slow.push_back(slow.back() + p.slow * kTick);
      fast.push_back(fast.back() + p.fast * kTick);
    }
    const double low_speed = std::min(12 * spacing, 0.2 * length / slow.back());
    const double cruise = (length - low_speed * slow.back()) / fast.back();
    for (std::size_t i = 0; i < slow.size(); ++i) {
      travelled_.push_back(low_speed * slow[i] + cruise * fast[i]);
    }
    start_ = length - at_tick(kHoverStart);  // the cusp, s = 0, is reached at the hover
  }

  double distance(double t) const {
    if (t >= kHoverStart && t <= kHoverEnd) return 0;
    const double s = start_ + at_tick(t);
    return t < kHoverStart ? std::min(s, length_) : std::max(s - length_, 0.0);
  }

 private:
  static constexpr double kTick = 1.0 / 240;
  static constexpr int kTicks = static_cast<int>(kSeconds / kTick);
  double at_tick(double t) const {
    const double x = std::clamp(t / kTick, 0.0, static_cast<double>(kTicks));
    const auto i = std::min(static_cast<std::size_t>(x), travelled_.size() - 2);
    const double u = x - static_cast<double>(i);
    return travelled_[i] * (1 - u) + travelled_[i + 1] * u;
  }
  double length_, start_ = 0;
  std::vector<double> travelled_;
};

struct Corridor {
  double low, high, wish;
};

/// One flight in the making: everything by keyframe, the last of which is the first again.
class Flyover {
 public:
  explicit Flyover(const Ground& ground)
      : ground_(ground),
        scale_(scale_of(ground)),
        track_(ground),
        schedule_(track_.length(), scale_.spacing) {}

  Path path() const {
    const std::vector<double> z = heights();
    const std::vector<double> yaw = yaws();
    std::vector<Keyframe> keyframes;
    for (int i = 0; i < kKeyframes; ++i) {
      Keyframe k;
      k.t = i * kStep;
      k.eye = {plan(k.t), z[static_cast<std::size_t>(i)]};
      k.yaw = yaw[static_cast<std::size_t>(i)];
      k.pitch = phase_at(k.t).pitch * kPi / 180;
      keyframes.push_back(k);
    }
    keyframes.push_back(keyframes.front());
    keyframes.back().t = kSeconds;
    return raise_above_ground(std::move(keyframes), ground_, 1.5 * scale_.spacing);
  }

 private:
  glm::dvec2 plan(double t) const { return track_.at(schedule_.distance(t)); }

  // Lowest and highest ground within a keyframe's reach, and what the phase wishes above it.
  Corridor corridor(double t) const {
    constexpr int kSamples = 16;
    double top = -1e300;
    double bottom = 1e300;
    for (int s = -kSamples; s <= kSamples; ++s) {
      const double near = std::fmod(t + s * kStep / kSamples + kSeconds, kSeconds);
      const double z = ground_at(ground_, plan(near));
      top = std::max(top, z);
      bottom = std::min(bottom, z);
    }
    const Phase p = phase_at(t);
    const double floor = 2 * scale_.spacing;  // for grids of few posts
    const auto blend = [&](double low, double middle, double high) {
      return p.low * low * scale_.spacing + p.middle * std::max(floor, middle * scale_.extent) +
             p.high * std::max(floor, high * scale_.extent);
    };
    Corridor c{top + blend(3.3, 0.012, 0.28), bottom + blend(9.5, 0.048, 0.32), 0};
    c.high = std::max(c.high, c.low);
    c.wish = std::clamp((top + bottom) / 2 + blend(5.5, 0.028, 0.30), c.low, c.high);
    return c;
  }

  // Over ground that is rougher than the corridor is high, the camera may glide from crest to crest
  // of the next half second instead of following every dip.
  static void allow_gliding(std::vector<Corridor>& corridors) {
    const std::size_t n = corridors.size();
    for (std::size_t i = 0; i < n; ++i) {
      for (const std::size_t step : {n - 2, n - 1, std::size_t{1}, std::size_t{2}}) {
        corridors[i].high = std::max(corridors[i].high, corridors[(i + step) % n].low);
      }
    }
  }

  // The smoothest heights within the corridors: smoothing and clamping by turns.
  std::vector<double> heights() const {
    constexpr int kRounds = 60;
    std::vector<Corridor> corridors;
    std::vector<double> z;
    for (int i = 0; i < kKeyframes; ++i) {
      corridors.push_back(corridor(i * kStep));
      z.push_back(corridors.back().wish);
    }
    const std::size_t n = z.size();
    allow_gliding(corridors);
    std::vector<double> smooth(n);
    for (int round = 0; round < kRounds; ++round) {
      for (std::size_t i = 0; i < n; ++i) {
        smooth[i] = (z[(i + n - 1) % n] + 2 * z[i] + z[(i + 1) % n]) / 4;
      }
      for (std::size_t i = 0; i < n; ++i) {
        z[i] = std::clamp(smooth[i], corridors[i].low, corridors[i].high);
      }
    }
    const auto first = static_cast<std::size_t>(kHoverStart / kStep);
    const auto last = static_cast<std::size_t>(kHoverEnd / kStep);
    const double hover = *std::max_element(z.begin() + static_cast<std::ptrdiff_t>(first),
                                           z.begin() + static_cast<std::ptrdiff_t>(last) + 1);
    for (std::size_t i = first; i <= last; ++i) z[i] = hover;
    return z;
  }

  // Along the track, half a second ahead, not across the cusp; the higher, the more towards the
  // middle of the land, so that it fills the picture.
  double heading(double t) const {
    const double limit = t <= kHoverStart ? kHoverStart : kSeconds + kHoverStart;
    const double ahead = std::min(t + 0.5, limit);
    const double behind = std::min(t, limit - 0.5);
    const glm::dvec2 here = plan(std::fmod(behind, kSeconds));
    const glm::dvec2 along = plan(std::fmod(ahead, kSeconds)) - here;
    const glm::dvec2 inward =
        ground_.world_from_post.apply((ground_.cols - 1) * 0.5, (ground_.rows - 1) * 0.5) - here;
    const Phase p = phase_at(t);
    const double share = (0.35 * p.middle + 1.8 * p.high) / std::max(glm::length(inward), 1e-9);
    const glm::dvec2 d = along / std::max(glm::length(along), 1e-9) + share * inward;
    return std::atan2(d.x, d.y);
  }

  // From the end of the hover around to its start, then the turn itself.
  std::vector<double> yaws() const {
    const int first = static_cast<int>(kHoverEnd / kStep);
    const int count = kKeyframes - static_cast<int>((kHoverEnd - kHoverStart) / kStep) + 1;
    std::vector<double> around;
    for (int i = 0; i < count; ++i) {
      const double yaw = heading(std::fmod((first + i) * kStep, kSeconds));
      const double before = around.empty() ? yaw : around.back();
      around.push_back(yaw - 2 * kPi * std::round((yaw - before) / (2 * kPi)));
    }
    smooth_inside(around);
    std::vector<double> yaw(kKeyframes);
    for (int i = 0; i < count; ++i) {
      yaw[static_cast<std::size_t>((first + i) % kKeyframes)] = around[static_cast<std::size_t>(i)];
    }
    // The way out of a cusp is the way in: half a turn, but for the track's curvature.
    const double arrival = around.back();
    const double turn = kPi + std::remainder(around.front() - arrival - kPi, 2 * kPi);
    for (int i = static_cast<int>(kHoverStart / kStep); i < first; ++i) {
      yaw[static_cast<std::size_t>(i)] =
          arrival + turn * glm::smoothstep(kTurnStart, kTurnEnd, i * kStep);
    }
    return yaw;
  }

  // Rounds off hairpins of narrow grids; the ends stay.
  static void smooth_inside(std::vector<double>& v) {
    constexpr int kRounds = 12;
    std::vector<double> next = v;
    for (int round = 0; round < kRounds; ++round) {
      for (std::size_t i = 1; i + 1 < v.size(); ++i) {
        next[i] = (v[i - 1] + 2 * v[i] + v[i + 1]) / 4;
      }
      v = next;
    }
  }

  const Ground& ground_;
  Scale scale_;
  Track track_;
  Schedule schedule_;
};

}  // namespace

Path fly_over(const Ground& ground) {
  return Flyover(ground).path();
}

}  // namespace arete::scene
