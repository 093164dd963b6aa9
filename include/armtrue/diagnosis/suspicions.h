#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// What the readings of one set-up make likely and do not prove, as sentences: from some place on
/// they lie in another frame; the distances from one anchor have another scale than the others; all
/// links come out longer or shorter by one factor. The geometry is calibrated to see it. Empty if
/// there is nothing, or the campaign or the robot has several sessions.
std::vector<std::string> find_suspicions(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
