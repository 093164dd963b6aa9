#pragma once

#include "armtrue/calibration/calibration.h"
#include "armtrue/effects/catalogue.h"
#include "armtrue/search/trace.h"

namespace armtrue {

/// The robot of a fit with many small effects behind its own, named `kRemainder`, none of which
/// stands out enough to be a finding, that together predict what it leaves: the lasso (Tibshirani
/// 1996) on all candidates of the search, beside all that is in the model, which is then fitted
/// again with them. What depends on the time of this campaign says nothing of others; a column that
/// fewer than eight poses carry says too little of the rest: neither takes part. The penalty is the
/// highest that leaves hardly more (one standard error) of poses left out, in five folds drawn from
/// the seed, than any other; the robot is returned as it is where these poses gain less than one
/// standard error or, the less the fit lacks against the noise, not significantly (Student's t, p
/// of 0.16 to 0.005). Where there are more than 6000 equations, so many choose the effects and all
/// fit the rest.
Robot with_remainder(const CalibrationResult& fit, const Campaign& campaign,
                     const Catalogue& catalogue, const TraceOptions& options);

inline constexpr const char* kRemainder = "part of the remainder";

}  // namespace armtrue
