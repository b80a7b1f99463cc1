#include "arete/lod/level_field.h"

#include <algorithm>
#include <cmath>

namespace arete::lod {
namespace {

// e^[0] = 0, e^[l+1] = max(e[l+1], kappa e^[l], e^[l] + eps_min) [METHODS S3]
void grow(const float* knots, std::size_t n, double eps_min, float* hat) {
  hat[0] = 0;
  for (std::size_t l = 1; l < n; ++l) {
    const double least = std::max(LevelField::kKappa * hat[l - 1], hat[l - 1] + eps_min);
    hat[l] = std::max(knots[l], static_cast<float>(least));
  }
}

// The level at which the piecewise-linear error reaches `allowed`, in [0, n - 1].
float inverse(const float* hat, std::size_t n, double allowed) {
  std::size_t l = 0;
  while (l + 1 < n && hat[l + 1] <= allowed) ++l;
  if (l + 1 == n) return static_cast<float>(l);
  const double t = (allowed - hat[l]) / (double{hat[l + 1]} - hat[l]);
  // Down to a whole 1/65536: then lambda + 1 is exact in float, and with it "at most one level
  // apart".
  return static_cast<float>(static_cast<double>(l) + std::floor(t * 0x1p16) * 0x1p-16);
}

float at_level(const float* knots, std::size_t n, float level) {
  const auto l = std::min(static_cast<std::size_t>(level), n - 1);
  if (l + 1 == n) return knots[l];
  const float t = level - static_cast<float>(l);
  return (1 - t) * knots[l] + t * knots[l + 1];
}

}  // namespace

LevelField::LevelField(const PatchTable& table, double quantum_m)
    : table_(table), knots_(table.knots()), distance_(table) {
  const auto n = static_cast<std::size_t>(table.size());
  hat_uniform_.resize(n * knots_);
  hat_side_.resize(n * kSides * knots_);
  slack_.resize(n);
  allowed_.resize(n);
  level_.resize(n);
  neighbours_.assign(n * kSides, -1);
  for (int p = 0; p < table.size(); ++p) {
    if (!table.drawable(p)) continue;
    const auto i = static_cast<std::size_t>(p);
    // Two roundings, the height's and the morphed sum's, of half an ulp each.
    slack_[i] = std::max(std::abs(table.box_min(p).z), std::abs(table.box_max(p).z)) * 0x1p-23;
    grow(table.uniform(p), knots_, quantum_m / 2, &hat_uniform_[i * knots_]);
    for (const Side q : kAllSides) {
      const std::size_t s = i * kSides + static_cast<std::size_t>(q);
      grow(table.side(p, q), knots_, quantum_m / 2, &hat_side_[s * knots_]);
      neighbours_[s] = table.neighbour(p, q);
    }
  }
}

void LevelField::solve(glm::dvec3 eye, const ScreenError& error) {
  distance_.look_from(eye);
  for (int p = 0; p < table_.size(); ++p) {
    if (!table_.drawable(p)) continue;
    const auto i = static_cast<std::size_t>(p);
    allowed_[i] = std::max(0.0, error.allowed_m(distance_[p]) - slack_[i]);
    level_[i] = inverse(&hat_uniform_[i * knots_], knots_, allowed_[i]);
  }
  // Every constraint is monotone, so relaxing in any order ends at the same field; sweeping along
  // and against the rows settles most of it in two.
  sweeps_ = 0;
  do {
    changed_ = false;
    sweep_forward();
    if (!changed_) break;
    changed_ = false;
    sweep_backward();
    ++sweeps_;
  } while (changed_);
}

float LevelField::cap(int patch, Side q) const {
  const auto i = static_cast<std::size_t>(patch);
  return inverse(&hat_side_[(i * kSides + static_cast<std::size_t>(q)) * knots_], knots_,
                 allowed_[i]);
}

// Constraint (1) between p and its neighbour n across p's side q, in both directions.
void LevelField::relax(int p, int n, Side q) {
  if (n < 0) return;
  if (level_[static_cast<std::size_t>(p)] > level_[static_cast<std::size_t>(n)]) {
    std::swap(p, n);
    q = opposite(q);
  }
  const float own = level_[static_cast<std::size_t>(p)];
  float& other = level_[static_cast<std::size_t>(n)];
  if (other == own) return;
  const float bound = std::max(own, std::min(own + 1, cap(p, q)));
  if (other > bound) {
    other = bound;
    changed_ = true;
  }
}

void LevelField::sweep_forward() {
  for (int p = 0; p < table_.size(); ++p) {
    if (!table_.drawable(p)) continue;
    const int* n = &neighbours_[static_cast<std::size_t>(p) * kSides];
    relax(p, n[West], West);
    relax(p, n[North], North);
  }
}

void LevelField::sweep_backward() {
  for (int p = table_.size() - 1; p >= 0; --p) {
    if (!table_.drawable(p)) continue;
    const int* n = &neighbours_[static_cast<std::size_t>(p) * kSides];
    relax(p, n[East], East);
    relax(p, n[South], South);
  }
}

void LevelField::raise(std::span<const float> floor_level) {
  for (std::size_t i = 0; i < level_.size(); ++i) level_[i] = std::max(level_[i], floor_level[i]);
  do {
    changed_ = false;
    for (const bool forward : {true, false}) {
      for (int k = 0; k < table_.size(); ++k) {
        const int p = forward ? k : table_.size() - 1 - k;
        if (!table_.drawable(p)) continue;
        float& own = level_[static_cast<std::size_t>(p)];
        for (const Side q : kAllSides) {
          const int n =
              neighbours_[static_cast<std::size_t>(p) * kSides + static_cast<std::size_t>(q)];
          if (n < 0 || level_[static_cast<std::size_t>(n)] - 1 <= own) continue;
          own = level_[static_cast<std::size_t>(n)] - 1;
          changed_ = true;
        }
      }
    }
  } while (changed_);
}

double LevelField::error(int patch) const {
  const auto i = static_cast<std::size_t>(patch);
  const float own = level_[i];
  float coarsest = own;
  double worst = at_level(table_.uniform(patch), knots_, own);
  for (const Side q : kAllSides) {
    const int n = neighbours_[i * kSides + static_cast<std::size_t>(q)];
    if (n < 0 || level_[static_cast<std::size_t>(n)] <= own) continue;
    coarsest = std::max(coarsest, level_[static_cast<std::size_t>(n)]);
    worst = std::max<double>(
        worst, at_level(table_.side(patch, q), knots_, level_[static_cast<std::size_t>(n)]));
  }
  return coarsest > 0 ? worst + slack_[i] : worst;  // level 0 is drawn as stored, to the bit
}

std::uint64_t LevelField::bytes() const {
  return (hat_uniform_.size() + hat_side_.size() + level_.size()) * sizeof(float) +
         (slack_.size() + allowed_.size()) * sizeof(double) + distance_.bytes() +
         neighbours_.size() * sizeof(int);
}

}  // namespace arete::lod
