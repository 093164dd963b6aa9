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
constexpr double kMaxStep = 0.3;      // [rad], [m]: limit of the linear model

Vector6 miss(const Pose& wanted, const Pose& reached) {
  Vector6 twist;
  twist << wanted.translation - reached.translation,
      rotation_log(wanted.rotation * reached.rotation.transpose());
  return twist;
}

bool is_small(const Vector6& twist) {
  return twist.head<3>().norm() < kTolerance && twist.tail<3>().norm() < kTolerance;
}

// kJoints: number of the joints if known when compiled, otherwise Eigen::Dynamic.
template <int kJoints>
using JointColumns =
    Eigen::Matrix<double, 6, kJoints, 0, 6, kJoints == Eigen::Dynamic ? kMaxJoints : kJoints>;

template <int kJoints>
JointColumns<kJoints> joint_columns(const KinematicChain& chain, const PoseJacobian& jacobian) {
  JointColumns<kJoints> columns(6, kJoints == Eigen::Dynamic ? joint_count(chain) : kJoints);
  int joint = 0;
  for (int j = 0; j < link_count(chain); ++j) {
    const Link& link = chain.links[static_cast<size_t>(j)];
    if (link.joint == JointKind::fixed) continue;
    const LinkParameter zero = is_prismatic(link) ? LinkParameter::r : LinkParameter::theta;
    columns.col(joint++) = link.sign * jacobian.col(link_parameter(j, zero));
  }
  return columns;
}

// Levenberg's step.
template <int kJoints>
JointVector step_towards(const JointColumns<kJoints>& columns, const Vector6& twist,
                         double damping) {
  if (columns.cols() > columns.rows()) {
    const Matrix6 normal = columns * columns.transpose() + damping * Matrix6::Identity();
    return columns.transpose() * normal.ldlt().solve(twist);
  }
  const auto joints = columns.cols();
  using Normal =
      Eigen::Matrix<double, kJoints, kJoints, 0, JointColumns<kJoints>::MaxColsAtCompileTime,
                    JointColumns<kJoints>::MaxColsAtCompileTime>;
  const Normal normal = columns.transpose() * columns + damping * Normal::Identity(joints, joints);
  const Eigen::Matrix<double, kJoints, 1, 0, JointColumns<kJoints>::MaxColsAtCompileTime, 1>
      change = normal.ldlt().solve(columns.transpose() * twist);
  return change;
}

double middle(const Link& link) {
  const auto [min, max] = travel(link);
  return 0.5 * (min + max);
}

template <int kJoints>
InverseResult solve_from(const KinematicChain& chain, const Pose& a_from_measured,
                         const JointVector& start) {
  const ChainEvaluator evaluator(chain);
  InverseResult result;
  result.q = start;
  PoseJacobian jacobian;
  Vector6 twist = miss(a_from_measured, evaluator.pose(start, jacobian));
  JointColumns<kJoints> columns = joint_columns<kJoints>(chain, jacobian);
  double damping = 1e-6;
  for (int step = 0; step < 100 && !is_small(twist) && damping < 1e6; ++step) {
    JointVector change = step_towards<kJoints>(columns, twist, damping);
    const double largest = change.cwiseAbs().maxCoeff();
    if (largest > kMaxStep) change *= kMaxStep / largest;
    const JointVector q = result.q + change;
    const Vector6 left = miss(a_from_measured, evaluator.pose(q, jacobian));
    if (!(left.squaredNorm() < twist.squaredNorm())) {
      damping *= 10;
      continue;
    }
    result.q = q;
    twist = left;
    columns = joint_columns<kJoints>(chain, jacobian);
    damping = std::max(0.1 * damping, 1e-15);
  }
  result.position_error = twist.head<3>().norm();
  result.orientation_error = twist.tail<3>().norm();
  result.reached = is_small(twist);
  return result;
}

}  // namespace

InverseResult inverse_kinematics(const KinematicChain& chain, const Pose& a_from_measured,
                                 const JointVector& start) {
  return joint_count(chain) == 6 ? solve_from<6>(chain, a_from_measured, start)
                                 : solve_from<Eigen::Dynamic>(chain, a_from_measured, start);
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
    for (int j = 0; j < joint_count(chain); ++j) {
      const Link& link = joint_link(chain, j);
      double& q = found.q[j];
      const double centre = middle(link);
      if (!is_prismatic(link)) q = centre + std::remainder(q - centre, 2 * std::numbers::pi);
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
  for (int j = 0; j < joint_count(chain); ++j)
    if (const Link& link = joint_link(chain, j); q[j] < link.min || q[j] > link.max) return j;
  return -1;
}

}  // namespace armtrue
