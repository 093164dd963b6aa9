#pragma once

#include <Eigen/Core>

#include "armtrue/identification/campaign.h"

namespace armtrue {

/// Sphere in R_A [m].
struct Zone {
  Eigen::Vector3d centre;
  double radius;
};

/// Lets readings count less the farther they lie outside a zone, by 1 / (1 + (distance from the
/// sphere / its radius)^2): what the model cannot follow everywhere it then follows there. Written
/// into the standard deviations of the readings; those that are stated keep their part. Throws
/// std::invalid_argument for distances, which do not show where they were read.
void favour(Campaign& campaign, const Zone& zone);

}  // namespace armtrue
