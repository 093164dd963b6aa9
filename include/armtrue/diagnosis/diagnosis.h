#pragma once

#include <string>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Mistakes of a file that the numbers themselves give away: wrong units, columns exchanged, left
/// hands, orientations in another convention, a joint counted backwards. Each is tried with the
/// base registered anew, and named with its remedy if it explains the readings ten times better
/// than the file as it stands, and that leaves more than a robot can be off. Where none does,
/// readings that no calibration brings near this robot, or only one that changes a link as no arm
/// errs, are named as such. Empty if all is plausible.
std::vector<std::string> diagnose(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
