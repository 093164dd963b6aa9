#pragma once

#include <optional>
#include <string>

#include "armtrue/calibration/calibration.h"
#include "armtrue/effects/robot.h"
#include "diagnosis/plain_fit.h"

namespace armtrue {

inline constexpr const char* kCheckColumnsAndJoints =
    "; check units, order and signs of the columns, and of each joint its direction ('sign') and "
    "zero ('theta_deg') in the robot file";

/// Names a parameter of a link that a calibration changes by more than 100 mm or 0.5 rad, and by
/// five standard deviations: a weakly observable parameter may change much without significance.
std::optional<std::string> find_impossible_change(const Robot& nominal,
                                                  const CalibrationResult& result);

/// The same from 20 mm or 0.1 rad on, where a calibration succeeds and predicts well, but the
/// controller's model, which it corrects, may not be that of the robot file. Nothing if the robot
/// file, with base and tool placed, errs by less than a twentieth of that (an angle by 1 m).
std::optional<std::string> find_unlikely_change(const Robot& nominal, const PlainFit& fit);

}  // namespace armtrue
