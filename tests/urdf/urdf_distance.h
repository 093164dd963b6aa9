#pragma once

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "armtrue/kinematics/evaluator.h"
#include "urdf_kinematics.h"

namespace armtrue {

inline std::string read_test_file(const std::string& name) {
  std::ifstream file(std::string(ARMTRUE_TESTS "/") + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Random values of the driven joints within their limits.
inline std::vector<double> random_joints(const oracle::UrdfArm& arm, std::mt19937_64& random) {
  std::vector<double> q;
  for (const oracle::UrdfJoint& joint : arm.joints())
    if (joint.is_driven)
      q.push_back(std::uniform_real_distribution(joint.lower, joint.upper)(random));
  return q;
}

struct Distance {
  double place = 0, attitude = 0;  // [m], of matrix entries
};

// The largest of 50 random poses between the arm of a document and a robot.
inline Distance distance_between(const oracle::UrdfArm& arm, const KinematicChain& chain) {
  const ChainEvaluator evaluator(chain);
  std::mt19937_64 random(7);
  Distance result;
  for (int k = 0; k < 50; ++k) {
    const std::vector<double> q = random_joints(arm, random);
    const KDL::Frame expected = arm.pose(q);
    const Pose pose =
        evaluator.pose(Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<long>(q.size())));
    for (int row = 0; row < 3; ++row) {
      result.place = std::max(result.place, std::abs(pose.translation[row] - expected.p(row)));
      for (int column = 0; column < 3; ++column)
        result.attitude = std::max(result.attitude,
                                   std::abs(pose.rotation(row, column) - expected.M(row, column)));
    }
  }
  return result;
}

}  // namespace armtrue
