#pragma once

// A small linear problem made by hand, seen through the classes of the scan: the candidates follow
// joint angles, which are random numbers here, and the derivatives of the parameters are random
// columns. No robot and no calibration decide what is in it.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armtrue/kinematics/parameters.h"
#include "armtrue/statistics/random.h"
#include "kinematics/six_axes.h"
#include "search/linearization.h"
#include "search/projection.h"

namespace armtrue {

inline Eigen::MatrixXd normal_matrix(Random& random, Eigen::Index rows, Eigen::Index columns) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(); });
}

/// A robot of which only the names of the links count.
inline Robot robot_by_hand() {
  Robot robot;
  robot.chain.links = six_axis_links();
  for (int j = 0; j < kLinks; ++j) robot.chain.links[j].name = "A" + std::to_string(j + 1);
  return robot;
}

inline int parameter_by_hand(const std::string& name) {
  return *find_parameter(robot_by_hand().chain, name);
}

/// Follows joint angle `joint` (0-based).
inline Candidate candidate_of(const std::string& parameter, int joint,
                              ShapeKind kind = ShapeKind::linear) {
  Candidate candidate;
  candidate.effect = {
      "by hand", parameter, {DriverKind::joint_angle, joint, -1, ""}, Shape{kind}, {}};
  return candidate;
}

/// `poses` poses, each read `repeats` times with the same joint angles.
inline Campaign angles_by_hand(Random& random, int poses, int repeats = 1) {
  Campaign campaign;
  for (int pose = 0; pose < poses; ++pose) {
    campaign.pose_ids.push_back(std::to_string(pose + 1));
    JointVector q(6);
    for (double& angle : q) angle = random.uniform(-1.5, 1.5);
    for (int repeat = 0; repeat < repeats; ++repeat) {
      campaign.pose.push_back(pose);
      campaign.q.push_back(q);
      campaign.position.emplace_back(0, 0, 0);
    }
  }
  return campaign;
}

/// Random derivatives of every parameter, a random model of `geometric` columns, no readings yet.
inline LinearProblem problem_by_hand(Random& random, const Campaign& campaign, int geometric) {
  LinearProblem problem;
  problem.pose = campaign.pose;
  problem.row_size = 3;
  const Eigen::Index equations = 3 * campaign.rows();
  problem.jacobian = normal_matrix(random, equations, kTargetParameters);
  problem.fitted = normal_matrix(random, equations, geometric);
  problem.geometric = geometric;
  problem.readings = Eigen::VectorXd::Zero(equations);
  return problem;
}

}  // namespace armtrue
