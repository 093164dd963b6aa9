#pragma once

#include "armtrue/calibration/calibration.h"

namespace armtrue {

/// One step of a search: fits a model near that of `near` to nearly the same campaign
/// (CalibrationOptions::start_near), with FitStatistics::weights. `max_rounds`: see
/// CalibrationOptions; 1 keeps the law of `near`. `robust`: see there.
CalibrationResult refit(const Robot& robot, const Campaign& campaign, const CalibrationResult& near,
                        double tolerance, int max_rounds = CalibrationOptions{}.max_rounds,
                        bool robust = true);

}  // namespace armtrue
