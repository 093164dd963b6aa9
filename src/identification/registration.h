#pragma once

#include "armtrue/effects/robot.h"
#include "armtrue/identification/campaign.h"

namespace armtrue {

/// The base pose that best carries the robot's own points onto the measured ones (Umeyama's closed
/// form, robustly repeated on the nearer half). Used to start from a file whose base is unknown.
Pose register_base(const Robot& robot, const Campaign& campaign);

}  // namespace armtrue
