#pragma once

#include <Eigen/Core>

#include "armtrue/calibration/identifiability.h"
#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// The measured points as the robot without effects predicts them, in the R_A of
/// `robot.chain.base`, one column per row.
Eigen::Matrix3Xd own_points(Robot robot, const Campaign& campaign);

/// The base pose that best maps the robot's own points, without effects, onto the measured ones;
/// fitted to all, then twice to the half with the smaller errors. Used where the base in the robot
/// file is unknown.
/// Points (and coordinates, if there are four points): Umeyama's closed form. Distances: the place
/// of each anchor in R_0 by trilateration, |p - a|^2 = l^2, linear in a and |a|^2, then the places
/// are mapped onto those in the file. With two anchors the rotation of the base about the
/// connecting line is kept, with one all rotations. Throws as match_anchors().
Pose registered_base(const Robot& robot, const Campaign& campaign);

/// The robot that calibration starts from: as in the first session of the campaign, with a base for
/// each session. A base that misses the readings by 80 mm (median) or more, and that is to be
/// identified, is replaced by registered_base() if that misses by less.
Robot starting_robot(const Robot& robot, const Campaign& campaign, const IdentifiableSet& set);

}  // namespace armtrue
