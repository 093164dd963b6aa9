#pragma once

#include "armtrue/calibration/calibration.h"

namespace armtrue {

/// Significance level for something beyond a fit: `with_lack` if the p of the lack of fit in
/// position is at most 0.001, `without_lack` if it is 1 or no noise is known, log-interpolated
/// between. An effect without a lack of fit is a stranger claim, and needs the stronger evidence.
double significance_level(const CalibrationResult& fit, const Campaign& campaign, double with_lack,
                          double without_lack);

}  // namespace armtrue
