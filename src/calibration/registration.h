#pragma once

#include <Eigen/Core>

#include "armtrue/calibration/identifiability.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// The points that the instrument looked at, as the robot without effects sees them, in the R_A of
/// `robot.chain.base`, one column a row.
Eigen::Matrix3Xd own_points(Robot robot, const Campaign& campaign);

/// The base pose that best carries the robot's own points, without effects, onto what was measured,
/// robustly repeated on the nearer half. Used to start from a file whose base is unknown.
/// Measured points: Umeyama's closed form. Distances: the place of each anchor in R_0
/// (trilateration, linear in the place and its squared distance from the origin), carried onto the
/// places in the file; two anchors leave the turn of the base about the line between them as it is,
/// one all turns. Throws as
/// match_anchors().
Pose registered_base(const Robot& robot, const Campaign& campaign);

/// The robot that calibration starts from: as it is in the first session, with a base for each. A
/// base that is far off and to be found is registered.
Robot starting_robot(const Robot& robot, const Campaign& campaign, const IdentifiableSet& set);

}  // namespace armtrue
