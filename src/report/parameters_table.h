#pragma once

#include <string>

#include "armtrue/calibration/calibration.h"

namespace armtrue {

/// Identified parameters: nominal, new, change, standard deviation, share of the readings.
/// `nominal`: the robot before the calibration; `poses`: of the fit; `robot_key`: prefix of the
/// keys of the robot file, such as "robot:". Numbers that the robot file does not have get the keys
/// of the table of --parameters.
std::string parameters_table(const Robot& nominal, const CalibrationResult& result, int poses,
                             const std::string& robot_key);

}  // namespace armtrue
