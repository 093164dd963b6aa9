#pragma once

#include "armtrue/calibration/calibration.h"

namespace armtrue {

/// One step of a search: fits a model that is nearly that of `near` to nearly the same campaign
/// (CalibrationOptions::start_near), without what only a report needs. Of the result inverse_root,
/// covariance, share_of_readings, the priors' equations, rank, condition and observability are
/// empty, and no standard deviation is set; all else is as calibrate() finds it.
CalibrationResult refit(const Robot& robot, const Campaign& campaign, const CalibrationResult& near,
                        double tolerance);

}  // namespace armtrue
