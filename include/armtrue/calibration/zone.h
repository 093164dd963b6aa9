#pragma once

#include <Eigen/Core>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Sphere in R_A [m]; with several sessions, in the R_A of the first.
struct Zone {
  Eigen::Vector3d centre;
  double radius;
};

/// A zone, and where the readings are.
struct WeightedZone {
  Zone zone;
  int readings_inside = 0;
  double nearest_outside = 0;  ///< distance of the nearest reading from the sphere, 0 if one is
                               ///< inside [m]
};

/// Weights readings by 1 / (1 + (d / radius)^2), with d the distance of the point from the sphere,
/// 0 inside. A model that cannot fit everywhere then fits best in the zone. The points are computed
/// with the robot, at the bases from which its calibration starts, because distances do not show
/// points and each session has its own R_A. So each standard deviation is multiplied by sqrt(1 + (d
/// / radius)^2). Throws std::invalid_argument as choose_identifiable() does.
WeightedZone weight_by_zone(Campaign& campaign, const Robot& robot, const Zone& zone);

}  // namespace armtrue
