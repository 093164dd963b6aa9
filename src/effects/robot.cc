#include "armtrue/effects/robot.h"

#include <algorithm>
#include <cmath>

#include "armtrue/kinematics/parameters.h"

namespace armtrue {

bool is_of_positioner(const Robot& robot, int parameter) {
  return robot.ground_link && parameter < link_parameter(*robot.ground_link + 1, LinkParameter{});
}

Eigen::Vector3d upwards(const Robot& robot) {
  const double g = robot.gravity.norm();
  if (g == 0 || robot.ground_link) return Eigen::Vector3d::UnitZ();
  return robot.chain.base.rotation * (-robot.gravity / g);
}

bool knows_instrument(const Robot& robot) {
  if (robot.ground_link) return false;
  double reach = robot.chain.tool.translation.norm();
  for (const Link& link : robot.chain.links) {
    reach += std::abs(link.d) + std::abs(link.r);
    if (is_prismatic(link)) reach += std::max(std::abs(link.min), std::abs(link.max));
  }
  return robot.instrument || robot.chain.base.translation.norm() > reach;
}

}  // namespace armtrue
