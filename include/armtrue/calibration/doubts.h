#pragma once

#include <string>
#include <vector>

#include "armtrue/calibration/evaluation.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Where the readings that a fit leaves out stand together, as a sentence; empty if they lie as
/// blunders do, at random. A fault that lasts for a while puts them close together in time, a bad
/// reflector on one target (p < 0.001). `lines`: of the file, those of gross poses included;
/// ascending.
std::string left_out_together(const Campaign& campaign, const std::vector<int>& lines);

/// Why the readings contradict the noise that the rows or, without such a column, the robot file
/// state, as a sentence; empty if they do not. Replicates that scatter more than the robot file
/// says show that figures take for noise what changes from visit to visit; single readings that
/// scatter much less about the model show a wrong figure, beside which nothing can be found
/// (p < 0.001).
std::string contradiction_of_noise(const Robot& robot, const Campaign& campaign,
                                   const CalibrationResult& fit, const NoiseFloor& noise);

}  // namespace armtrue
