#pragma once

#include "armtrue/effects/robot.h"
#include "armtrue/identification/campaign.h"
#include "armtrue/identification/identifiability.h"

namespace armtrue {

/// The base pose that best carries the robot's own points onto the measured ones (Umeyama's closed
/// form, robustly repeated on the nearer half). Used to start from a file whose base is unknown.
Pose register_base(const Robot& robot, const Campaign& campaign);

/// The robot that calibration starts from: as it is in the first session, with a base for each. A
/// base that is far off and to be found is registered.
Robot starting_robot(const Robot& robot, const Campaign& campaign, const IdentifiableSet& set);

}  // namespace armtrue
