#pragma once

#include "armtrue/calibration/calibration.h"

namespace armtrue {

/// One step of a search: fits a model that is nearly that of `near` to nearly the same campaign
/// (CalibrationOptions::start_near), without figures that only a report needs. In the result
/// inverse_root, covariance, share_of_readings, the equations of the priors, rank, condition and
/// observability are empty, and no standard deviation is set. All else is as from calibrate().
CalibrationResult refit(const Robot& robot, const Campaign& campaign, const CalibrationResult& near,
                        double tolerance);

}  // namespace armtrue
