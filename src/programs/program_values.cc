#include "programs/program_values.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr double kRound = 2 * std::numbers::pi;

Eigen::Vector3d at_next_turn(Eigen::Vector3d angles, const Eigen::Vector3d& near) {
  for (int i = 0; i < 3; ++i) angles[i] += kRound * std::round((near[i] - angles[i]) / kRound);
  return angles;
}

// The rotation vectors v + 2 pi k v / |v| are one rotation.
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

Eigen::Vector3d fanuc_order(const Eigen::Vector3d& abc) { return {abc[2], abc[1], abc[0]}; }

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

Pose pose_of_numbers(Dialect dialect, const std::vector<double>& n) {
  const Eigen::Vector3d position(n[0], n[1], n[2]);
  switch (dialect) {
    case Dialect::krl:
      return {rotation_from_abc(n[3] * kDegree, n[4] * kDegree, n[5] * kDegree),
              position * kMillimetre};
    case Dialect::rapid:
      return {Eigen::Quaterniond(n[3], n[4], n[5], n[6]).normalized().toRotationMatrix(),
              position * kMillimetre};
    case Dialect::fanuc:
      return {rotation_from_abc(n[5] * kDegree, n[4] * kDegree, n[3] * kDegree),
              position * kMillimetre};
    case Dialect::urscript:
      break;
  }
  return {rotation_exp({n[3], n[4], n[5]}), position};
}

std::vector<double> numbers_of_pose(Dialect dialect, const Pose& pose,
                                    const std::vector<double>& written) {
  const Eigen::Vector3d mm = pose.translation / kMillimetre;
  const Eigen::Vector3d near(written[3], written[4], written[5]);
  switch (dialect) {
    case Dialect::krl: {
      const Eigen::Vector3d abc = abc_near(pose.rotation, near * kDegree) / kDegree;
      return {mm[0], mm[1], mm[2], abc[0], abc[1], abc[2]};
    }
    case Dialect::rapid: {
      const Eigen::Quaterniond of_text(written[3], written[4], written[5], written[6]);
      Eigen::Quaterniond q(pose.rotation);
      if (q.dot(of_text) < 0) q.coeffs() = -q.coeffs();
      return {mm[0], mm[1], mm[2], q.w(), q.x(), q.y(), q.z()};
    }
    case Dialect::fanuc: {
      const Eigen::Vector3d wpr =
          fanuc_order(abc_near(pose.rotation, fanuc_order(near) * kDegree)) / kDegree;
      return {mm[0], mm[1], mm[2], wpr[0], wpr[1], wpr[2]};
    }
    case Dialect::urscript:
      break;
  }
  const Eigen::Vector3d& p = pose.translation;
  const Eigen::Vector3d v = rotation_vector_near(pose.rotation, near);
  return {p[0], p[1], p[2], v[0], v[1], v[2]};
}

JointVector joints_of_numbers(Dialect dialect, const std::vector<double>& n) {
  JointVector q = Eigen::Map<const JointVector>(n.data(), kProgramAxes);
  if (dialect == Dialect::urscript) return q;
  if (dialect == Dialect::fanuc) q[2] += q[1];
  return q * kDegree;
}

std::vector<double> numbers_of_joints(Dialect dialect, const JointVector& q) {
  JointVector n = dialect == Dialect::urscript ? q : JointVector(q / kDegree);
  if (dialect == Dialect::fanuc) n[2] -= n[1];
  return {n.begin(), n.end()};
}

int quadrant(double angle) {
  return static_cast<int>(std::floor(angle / (0.5 * std::numbers::pi)));
}

}  // namespace armtrue
