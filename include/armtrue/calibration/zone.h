#pragma once

#include <Eigen/Core>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Sphere in R_A, of several sessions that of the first [m].
struct Zone {
  Eigen::Vector3d centre;
  double radius;
};

/// Lets readings count less the farther they lie outside a zone, by 1 / (1 + (distance from the
/// sphere / its radius)^2): what the model cannot follow everywhere it then follows there. Where
/// they lie the robot says, from the bases that its calibration starts from: distances do not show
/// it, and each session has an R_A of its own. Written into the standard deviations of the
/// readings; those that are stated keep their part. Throws std::invalid_argument as
/// choose_identifiable() does.
void weight_by_zone(Campaign& campaign, const Robot& robot, const Zone& zone);

}  // namespace armtrue
