#include "armtrue/effects/robot.h"

#include <algorithm>
#include <cmath>

namespace armtrue {

Eigen::Vector3d upwards(const Robot& robot) {
  const double g = robot.gravity.norm();
  if (g == 0) return Eigen::Vector3d::UnitZ();
  return robot.chain.base.rotation * (-robot.gravity / g);
}

bool knows_instrument(const Robot& robot) {
  double reach = robot.chain.tool.translation.norm();
  for (const Link& link : robot.chain.links) {
    reach += std::abs(link.d) + std::abs(link.r);
    if (is_prismatic(link)) reach += std::max(std::abs(link.min), std::abs(link.max));
  }
  return robot.instrument || robot.chain.base.translation.norm() > reach;
}

}  // namespace armtrue
