#pragma once

#include <string>

#include "armtrue/calibration/calibration.h"

namespace armtrue {

/// CSV: a row for each geometric parameter that was identified, then one for each coefficient of an
/// effect that was fitted. `nominal`: the robot before the calibration; `poses`: of the campaign.
/// See armtrue-formats(5), PARAMETERS.
std::string write_parameters(const Robot& nominal, const CalibrationResult& result, int poses);

/// CSV: the correlations of the rows of write_parameters(), a row and a column for each. Cells
/// without a variance are empty.
std::string write_correlations(const CalibrationResult& result);

}  // namespace armtrue
