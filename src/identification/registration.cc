#include "registration.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "armtrue/effects/robot_model.h"
#include "armtrue/identification/statistics.h"

namespace armtrue {

Pose register_base(const Robot& robot, const Campaign& campaign) {
  Robot at_origin = robot;
  at_origin.chain.base = Pose{};
  at_origin.effects.clear();
  const RobotModel model(at_origin);
  std::vector<int> targets;
  for (const std::string& name : campaign.target_names)
    for (size_t t = 0; t < robot.chain.targets.size(); ++t)
      if (robot.chain.targets[t].name == name) targets.push_back(static_cast<int>(t));
  Eigen::Matrix3Xd own(3, campaign.rows()), measured(3, campaign.rows());
  for (int row = 0; row < campaign.rows(); ++row) {
    const int target = targets.empty() ? -1 : targets[campaign.target[row]];
    own.col(row) = model.point(campaign.context(row), target);
    measured.col(row) = campaign.position[row];
  }
  Pose base;
  std::vector<int> chosen(campaign.rows());
  for (int row = 0; row < campaign.rows(); ++row) chosen[row] = row;
  for (int round = 0; round < 3; ++round) {
    const Eigen::Matrix4d transform =
        Eigen::umeyama(own(Eigen::all, chosen), measured(Eigen::all, chosen), false);
    base = {transform.topLeftCorner<3, 3>(), transform.topRightCorner<3, 1>()};
    std::vector<double> misses(campaign.rows());
    for (int row = 0; row < campaign.rows(); ++row)
      misses[row] = (measured.col(row) - base * Eigen::Vector3d(own.col(row))).norm();
    const double limit = median(misses);
    chosen.clear();
    for (int row = 0; row < campaign.rows(); ++row)
      if (misses[row] <= limit) chosen.push_back(row);
  }
  return base;
}

}  // namespace armtrue
