#pragma once

#include <span>
#include <vector>

#include "arete/core/screen_error.h"
#include "arete/lod/patch_distances.h"
#include "arete/lod/patch_field.h"
#include "arete/lod/patch_table.h"

namespace arete::lod {

/// The continuous level of every patch for one eye (METHODS S4, coupling made monotone).
///
/// Patch P at distance D_P may err by a_P = slope D_P metres, less what rounding in float may add.
/// Its own level is
///   lambda*_P = the piecewise-linear inverse of its uniform errors at a_P, in [0, w],
/// and side q of P may stand no coarser than c_Pq = the same inverse of its side errors. The field
/// is the greatest lambda <= lambda* with
///   lambda_Q <= max(lambda_P, min(lambda_P + 1, c_Pq))   for all neighbours P, Q.       (1)
/// Then P's interior errs by at most a_P (lambda_P <= lambda*_P), its side strips too (a side
/// stands at max(lambda_P, lambda_Q), and side errors bound a band for every interior level that
/// may meet it), and integer levels of neighbours differ by at most 1.
///
/// Deviation: METHODS S4(b) caps by the strip error at P's actual level, which depends on the order
/// of settling and can jump. (1) is monotone in lambda with constants that depend on the eye only:
/// the greatest solution is unique, reached by relaxing in any order, and moves no faster than
/// lambda* and c do: knots grow by kappa, so |d lambda| <= kappa/(kappa-1) |da|/a.
class LevelField final : public PatchField {
 public:
  static constexpr double kKappa = 1.5;  ///< least growth of errors from level to level

  explicit LevelField(const PatchTable& table, double quantum_m);

  /// Solves (1) for the eye. Levels never fall when the tolerance grows. Cost: O(patches), a few
  /// sweeps; distances are measured only when the eye has moved.
  void solve(glm::dvec3 eye, const ScreenError& error);
  /// Raises levels so that no patch is finer than `floor_level[patch]` and neighbours still differ
  /// by at most 1 (tiles that are not there: the error grows, the surface stays conforming).
  void raise(std::span<const float> floor_level) override;

  float level(int patch) const override { return level_[static_cast<std::size_t>(patch)]; }
  double distance(int patch) const override { return distance_[patch]; }
  double error(int patch) const override;
  std::uint64_t bytes() const override;
  /// Sweeps that the last solve took.
  int sweeps() const { return sweeps_; }

 private:
  void relax(int p, int n, Side q);
  void sweep_forward();
  void sweep_backward();
  float cap(int patch, Side q) const;

  const PatchTable& table_;
  std::size_t knots_;
  PatchDistances distance_;
  int sweeps_ = 0;
  bool changed_ = false;
  std::vector<float> hat_uniform_, hat_side_;  ///< knots made to grow by kappa
  std::vector<double> slack_;    ///< metres that a vertex stage in float may add while it morphs
  std::vector<double> allowed_;  ///< metres
  std::vector<float> level_;
  std::vector<int> neighbours_;  ///< kSides a patch, -1 = none
};

}  // namespace arete::lod
