#include "armtrue/calibration/zone.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "armtrue/calibration/identifiability.h"
#include "armtrue/observation/registration.h"

namespace armtrue {

WeightedZone weight_by_zone(Campaign& campaign, const Robot& robot, const Zone& zone) {
  const Eigen::Matrix3Xd points = own_points(
      starting_robot(robot, campaign, require_identifiable(robot, campaign).kept), campaign);
  // Only the ratios of the standard deviations count.
  const size_t rows = campaign.rows();
  if (campaign.sigma_position.empty()) campaign.sigma_position.assign(rows, 1e-3);
  if (campaign.has_orientation() && campaign.sigma_orientation.empty())
    campaign.sigma_orientation.assign(rows, 1e-3);
  WeightedZone weighted{zone, 0, std::numeric_limits<double>::infinity()};
  for (size_t row = 0; row < rows; ++row) {
    const Eigen::Vector3d point = points.col(row);
    const double outside = std::max(0.0, (point - zone.centre).norm() - zone.radius);
    weighted.readings_inside += outside == 0;
    weighted.nearest_outside = std::min(weighted.nearest_outside, outside);
    const double factor = std::hypot(1.0, outside / zone.radius);
    campaign.sigma_position[row] *= factor;
    if (campaign.has_orientation()) campaign.sigma_orientation[row] *= factor;
  }
  return weighted;
}

}  // namespace armtrue
