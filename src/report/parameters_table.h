#pragma once

#include <string>

#include "armtrue/calibration/calibration.h"

namespace armtrue {

/// Identified parameters: nominal, new, change, standard deviation, share of the readings.
/// `nominal`: the robot before the calibration; `poses`: of the fit; `robot_key`: what stands
/// before the keys of the robot file, such as "robot:". Numbers that only the table of --parameters
/// has too have its keys.
std::string parameters_table(const Robot& nominal, const CalibrationResult& result, int poses,
                             const std::string& robot_key);

}  // namespace armtrue
