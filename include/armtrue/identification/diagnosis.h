#pragma once

#include <string>
#include <vector>

#include "armtrue/effects/robot.h"
#include "armtrue/identification/campaign.h"

namespace armtrue {

/// Mistakes of a file that the numbers themselves give away: angles in radians under a _deg name,
/// metres under _mm, A and C exchanged, quaternions turned the other way, a joint counted
/// backwards. Each is tried with the base registered anew, and named with its remedy if it explains
/// the readings ten times better than the file as it stands, and that leaves more than a robot can
/// be off. Empty if all is plausible.
std::vector<std::string> diagnose(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
