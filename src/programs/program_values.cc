#include "programs/program_values.h"

#include <cmath>
#include <numbers>

#include "armtrue/kinematics/pose.h"

namespace armtrue {
namespace {

constexpr double kRound = 2 * std::numbers::pi;

Eigen::Vector3d at_next_turn(Eigen::Vector3d angles, const Eigen::Vector3d& near) {
  for (int i = 0; i < 3; ++i) angles[i] += kRound * std::round((near[i] - angles[i]) / kRound);
  return angles;
}

}  // namespace

Eigen::Vector3d abc_near(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& near) {
  const Eigen::Vector3d exact = abc_from_rotation(rotation);
  const Eigen::Vector3d other(exact[0] + std::numbers::pi, std::numbers::pi - exact[1],
                              exact[2] + std::numbers::pi);
  Eigen::Vector3d best = at_next_turn(exact, near);
  const auto take = [&](const Eigen::Vector3d& angles) {
    constexpr double kSame = 2e-7;  // [rad]
    const Eigen::Vector3d turned = at_next_turn(angles, near);
    const Eigen::Matrix3d reached = rotation_from_abc(turned[0], turned[1], turned[2]);
    if (rotation_log(rotation * reached.transpose()).norm() > kSame) return;
    if ((turned - near).cwiseAbs().maxCoeff() < (best - near).cwiseAbs().maxCoeff()) best = turned;
  };
  for (const Eigen::Vector3d& angles : {exact, other}) {
    take(angles);
    // Near b = +-pi/2 noise turns a and c against each other: keep c where that gives the rotation.
    const double sign = std::sin(angles[1]) > 0 ? 1 : -1;
    take({angles[0] + sign * (near[2] - angles[2]), angles[1], near[2]});
  }
  return best;
}

Eigen::Vector3d rotation_vector_near(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& near) {
  const Eigen::Vector3d shortest = rotation_log(rotation);
  const double angle = shortest.norm();
  const bool is_nothing = angle < 1e-12;
  if (is_nothing && near.norm() < 1e-3) return shortest;
  const Eigen::Vector3d axis = is_nothing ? near.normalized() : Eigen::Vector3d(shortest / angle);
  Eigen::Vector3d best = shortest;
  for (int k = -2; k <= 2; ++k) {
    const Eigen::Vector3d other = (angle + k * kRound) * axis;
    if ((other - near).norm() < (best - near).norm()) best = other;
  }
  return best;
}

}  // namespace armtrue
