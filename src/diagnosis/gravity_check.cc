#include "diagnosis/gravity_check.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <vector>

#include "armtrue/effects/gravity.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/parameters.h"

namespace armtrue {
namespace {

// Of a joint at each reading [N m].
Eigen::VectorXd torques(const GravityLoad& load, const ChainEvaluator& chain,
                        const Campaign& readings) {
  Eigen::VectorXd torque(readings.rows());
  for (int row = 0; row < readings.rows(); ++row)
    load.values(readings.context(row), chain.link_frames(readings.q[row]), &torque[row]);
  return torque;
}

}  // namespace

std::optional<std::string> find_reversed_gravity(const PlainFit& fit) {
  constexpr double kThird = 1.0 / 3, kSmallestTorque = 1;  // N m
  const Robot& robot = fit.result.robot;
  if (robot.bodies.empty() || fit.readings.rows() == 0) return std::nullopt;
  const ChainEvaluator chain(robot.chain);
  std::vector<int> joints, parameters;
  std::vector<Eigen::VectorXd> torque_of;
  for (int joint = 0; joint < joint_count(robot.chain); ++joint) {
    if (is_prismatic(joint_link(robot.chain, joint))) continue;
    const int parameter = zero_offset(robot.chain, joint);
    const GravityLoad load(robot, parameter);
    if (!load.is_by_masses()) continue;
    const Eigen::VectorXd torque = torques(load, chain, fit.readings);
    if (torque.maxCoeff() - torque.minCoeff() < kSmallestTorque) continue;
    joints.push_back(joint);
    parameters.push_back(parameter);
    torque_of.push_back(torque);
  }
  if (joints.empty()) return std::nullopt;
  const FitEquations equations = fit_equations(fit, parameters);
  JointFit best;
  int joint = 0;
  for (int k = 0; k < std::ssize(joints); ++k) {
    const JointFit one =
        fit_beside(times_of_rows(equations.columns.col(k), torque_of[k]), equations);
    if (one.share <= best.share) continue;
    best = one;
    joint = joints[k];
  }
  const double choices = 2.0 * static_cast<double>(joints.size());
  if (best.share < kThird || best.value[0] > 0 ||
      fall_of_bic(best, equations, fit.poses(), choices) < kClearFall)
    return std::nullopt;
  return fmt::format(
      "{} turns against the torque of gravity, by {:.2g} rad/(N m), which explains {:.0f} % of "
      "the squared error: no joint gives way so. Is `gravity` that of this arm (of one at the "
      "ceiling it points along +z of R_0), and has it a counterbalance that the masses lack?",
      joint_link(robot.chain, joint).name, -best.value[0], 100 * best.share);
}

}  // namespace armtrue
