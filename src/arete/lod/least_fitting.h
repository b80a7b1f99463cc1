#pragma once

#include <functional>

#include "arete/lod/engine.h"

namespace arete::lod {

/// log(need / cap) of the tighter of the two caps; <= 0 fits.
double excess(const Budget& need, const Budget& cap);

/// The least x >= 0, to within kFitStep, with excess(x) <= 0, for an excess that never grows with x
/// and is log(need / cap), so that a step of its own size is a fair guess. Its last call was with
/// the result. Gives kMostCoarse when nothing up to there fits. Depends on the excess alone, not
/// on earlier searches. Cost: some eight calls.
double least_fitting(const std::function<double(double)>& excess);

inline constexpr double kFitStep = 1e-3;
inline constexpr double kMostCoarse = 100;

}  // namespace arete::lod
