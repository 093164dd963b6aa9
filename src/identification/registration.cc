#include "registration.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "armtrue/effects/robot_model.h"
#include "armtrue/identification/statistics.h"
#include "sessions.h"

namespace armtrue {
namespace {

// A base that misses by more than this is not a calibration error but a set-up nobody told us.
constexpr double kFarBase = 0.08;  // m

Robot with_base_near(const Robot& robot, const Campaign& campaign) {
  const auto typical_miss = [&](const Robot& candidate) {
    const SessionModels model(campaign, candidate, {}, {1.0, 1.0});
    std::vector<double> squares;
    for (const Eigen::Vector2d& norms :
         model.squared_norms(Eigen::VectorXd::Zero(model.unknowns())))
      squares.push_back(norms[0]);
    return std::sqrt(median(std::move(squares)));
  };
  if (typical_miss(robot) < kFarBase) return robot;
  Robot moved = robot;
  moved.chain.base = register_base(robot, campaign);
  return typical_miss(moved) < typical_miss(robot) ? moved : robot;
}

}  // namespace

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

Robot starting_robot(const Robot& robot, const Campaign& campaign, const IdentifiableSet& set) {
  bool finds_first_base = true;
  for (int k = 0; k < 6; ++k)
    finds_first_base &=
        std::find(set.kept.begin(), set.kept.end(), kBaseParameters + k) != set.kept.end();
  const std::vector<std::vector<int>> sessions = rows_by_session(campaign);
  if (sessions.size() == 1) {
    const Robot there = robot_at_row(robot, campaign, 0);
    return finds_first_base ? with_base_near(there, campaign) : there;
  }
  Robot start = robot;
  start.sessions.clear();
  for (size_t s = 0; s < sessions.size(); ++s) {
    const Campaign readings = campaign.select(sessions[s]);
    Robot there = robot_at_row(robot, readings, 0);
    if (s > 0 || finds_first_base) there = with_base_near(there, readings);
    if (s == 0) start.chain = there.chain;
    const std::string& name = readings.session_names[readings.session.front()];
    const auto known = robot.sessions.find(name);
    if (known != robot.sessions.end()) start.sessions[name] = known->second;
    start.sessions[name].base = there.chain.base;
  }
  return start;
}

}  // namespace armtrue
