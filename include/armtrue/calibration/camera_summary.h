#pragma once

#include <string>
#include <vector>

#include "armtrue/calibration/calibration.h"
#include "armtrue/calibration/evaluation.h"

namespace armtrue {

/// What a calibration from images says of its cameras and boards, for people, a sentence each:
/// where they are, with 95 % bounds, and by how much the images are missed, in pixels and at the
/// board. Where no link is identified (hand-eye alone) also by how much images are missed that the
/// fit has not used, a fifth of the poses at a time. Empty for other readings. `nominal`: the robot
/// that was calibrated.
std::vector<std::string> cameras_in_words(const Robot& nominal, const CalibrationResult& result,
                                          const Campaign& campaign, const Evaluation& evaluation);

}  // namespace armtrue
