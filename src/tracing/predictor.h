#pragma once

#include "armtrue/calibration/calibration.h"
#include "armtrue/effects/catalogue.h"
#include "armtrue/search/trace.h"

namespace armtrue {

/// Returns the robot of a fit with many small effects, named `kRemainder`, added after its own.
/// None of them is a finding; together they predict a part of the residual. The lasso (Tibshirani
/// 1996) chooses them among all candidates of the search, beside the model, which is then fitted
/// again with them. Two kinds of candidates are left out: effects driven by time, because they say
/// nothing about other campaigns, and columns that fewer than eight poses determine. The penalty is
/// chosen by cross-validation over five folds drawn from the seed: the highest one whose error on
/// the poses left out is within one standard error of the smallest. The robot is returned unchanged
/// if the gain on the poses left out is not significant by Student's t: the level is 0.16 (one
/// standard error) with a clear lack of fit, 0.005 without one. With more than 6000 equations, the
/// lasso uses 6000 of them; the last fit uses all.
Robot with_remainder(const CalibrationResult& fit, const Campaign& campaign,
                     const Catalogue& catalogue, const TraceOptions& options);

inline constexpr const char* kRemainder = "part of the remainder";

}  // namespace armtrue
