#include "armtrue/kinematics/inverse.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "armtrue/kinematics/evaluator.h"

namespace armtrue {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kTolerance = 1e-10;  // [m], [rad]
constexpr double kMaxStep = 0.3;      // [rad]: limit of the linear model

Vector6 miss(const Pose& wanted, const Pose& reached) {
  Vector6 twist;
  twist << wanted.translation - reached.translation,
      rotation_log(wanted.rotation * reached.rotation.transpose());
  return twist;
}

bool is_small(const Vector6& twist) {
  return twist.head<3>().norm() < kTolerance && twist.tail<3>().norm() < kTolerance;
}

Matrix6 joint_columns(const KinematicChain& chain, const PoseJacobian& jacobian) {
  Matrix6 columns;
  for (int j = 0; j < kJoints; ++j)
    columns.col(j) = chain.links[static_cast<size_t>(j)].sign *
                     jacobian.col(link_parameter(j, LinkParameter::theta));
  return columns;
}

double middle(const Link& link) {
  return std::isfinite(link.min) && std::isfinite(link.max) ? 0.5 * (link.min + link.max) : 0.0;
}

}  // namespace

InverseResult inverse_kinematics(const KinematicChain& chain, const Pose& a_from_measured,
                                 const JointVector& start) {
  const ChainEvaluator evaluator(chain);
  InverseResult result;
  result.q = start;
  PoseJacobian jacobian;
  Vector6 twist = miss(a_from_measured, evaluator.pose(start, jacobian));
  Matrix6 columns = joint_columns(chain, jacobian);
  double damping = 1e-6;
  for (int step = 0; step < 100 && !is_small(twist) && damping < 1e6; ++step) {
    const Matrix6 normal = columns.transpose() * columns + damping * Matrix6::Identity();
    JointVector change = normal.ldlt().solve(columns.transpose() * twist);
    const double largest = change.cwiseAbs().maxCoeff();
    if (largest > kMaxStep) change *= kMaxStep / largest;
    const JointVector q = result.q + change;
    const Vector6 left = miss(a_from_measured, evaluator.pose(q, jacobian));
    if (left.squaredNorm() >= twist.squaredNorm()) {
      damping *= 10;
      continue;
    }
    result.q = q;
    twist = left;
    columns = joint_columns(chain, jacobian);
    damping = std::max(0.1 * damping, 1e-15);
  }
  result.position_error = twist.head<3>().norm();
  result.orientation_error = twist.tail<3>().norm();
  result.reached = is_small(twist);
  return result;
}

std::optional<JointVector> inverse_kinematics(const KinematicChain& chain,
                                              const Pose& a_from_measured,
                                              const std::vector<JointVector>& starts) {
  std::optional<JointVector> best;
  double least = 0;
  for (const JointVector& start : starts) {
    InverseResult found = inverse_kinematics(chain, a_from_measured, start);
    if (!found.reached) continue;
    double distance = 0;
    for (int j = 0; j < kJoints; ++j) {
      double& q = found.q[j];
      const double centre = middle(chain.links[j]);
      q = centre + std::remainder(q - centre, 2 * std::numbers::pi);
      distance = std::max(distance, std::abs(q - centre));
    }
    if (joint_beyond_travel(chain, found.q) >= 0) continue;
    if (best && distance >= least) continue;
    best = found.q;
    least = distance;
  }
  return best;
}

int joint_beyond_travel(const KinematicChain& chain, const JointVector& q) {
  for (int j = 0; j < kJoints; ++j)
    if (q[j] < chain.links[j].min || q[j] > chain.links[j].max) return j;
  return -1;
}

}  // namespace armtrue
