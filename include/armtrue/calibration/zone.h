#pragma once

#include <Eigen/Core>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"

namespace armtrue {

/// Sphere in R_A, with several sessions in that of the first [m].
struct Zone {
  Eigen::Vector3d centre;
  double radius;
};

/// A zone, and how the readings lie to it.
struct WeightedZone {
  Zone zone;
  int readings_inside = 0;
  double nearest_outside = 0;  ///< of the reading nearest to the sphere, 0 with readings inside [m]
};

/// Weights readings by 1 / (1 + (d / radius)^2), with d the distance of the point from the sphere,
/// 0 inside. A model that cannot fit everywhere then fits best in the zone. The points are computed
/// with the robot, at the bases from which its calibration starts, because distances do not show
/// points and each session has its own R_A. The weights are multiplied into the standard deviations
/// of the readings. Throws std::invalid_argument as choose_identifiable() does.
WeightedZone weight_by_zone(Campaign& campaign, const Robot& robot, const Zone& zone);

}  // namespace armtrue
