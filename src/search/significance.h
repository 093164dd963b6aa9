#pragma once

#include "armtrue/calibration/calibration.h"

namespace armtrue {

/// Significance level for adding something to a fit: `with_lack` if the p of the lack of fit in
/// position is at most 0.001, `without_lack` if it is 1 or no noise is known, log-interpolated
/// between. Without a lack of fit an effect is less likely, and needs stronger evidence.
double significance_level(const CalibrationResult& fit, const Campaign& campaign, double with_lack,
                          double without_lack);

}  // namespace armtrue
