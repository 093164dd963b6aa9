#include "compensation/joint_correction.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "compensation/branch.h"

namespace armtrue {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kLength = 0.1;          // [m]: a mrad counts as 0.1 mm
constexpr double kReached = 1e-10;       // [m], [rad]
constexpr double kGoodEnough = 1e-9;     // [m], [rad]: 1e-6 mm
constexpr double kLargestStep = 0.3;     // [rad]: limit of the linear model
constexpr int kNoJoint = -1, kWristJoint = 4;
// A wrist bent by less, or as little left of any other freedom, is near a singular posture.
constexpr double kNearWrist = 3 * kDegree;
const double kNearAny = kLength * std::sin(kNearWrist);

// Position and rotation by which `reached` misses `wanted`; the rotation times kLength [m].
Vector6 weighted_error(const Pose& wanted, const Pose& reached) {
  Vector6 error;
  error << wanted.translation - reached.translation,
      kLength * rotation_log(wanted.rotation * reached.rotation.transpose());
  return error;
}

bool is_within(const Vector6& error, double tolerance) {
  return error.head<3>().norm() < tolerance && error.tail<3>().norm() < kLength * tolerance;
}

// One minimisation, with one lambda; `held` is a joint that does not move, or kNoJoint.
class Minimum {
 public:
  Minimum(const ProgramArm& arm, const Context& context, const Pose& wanted,
          const JointVector& start, double lambda, int held)
      : arm_(arm), context_(context), wanted_(wanted), start_(start), lambda_(lambda), held_(held) {
    find();
  }

  const JointVector& q() const { return q_; }
  bool is_reached(double tolerance) const { return is_within(error_, tolerance); }

 private:
  void take(const JointVector& q) {
    q_ = q;
    context_.q = q;
    error_ = weighted_error(wanted_, arm_.pose(context_, jacobian_));
    jacobian_.bottomRows<3>() *= kLength;
  }

  double cost_at(const JointVector& q) const {
    Context context = context_;
    context.q = q;
    return weighted_error(wanted_, arm_.pose(context)).squaredNorm() +
           lambda_ * lambda_ * (q - start_).squaredNorm();
  }

  JointVector step(double damping) const {
    Matrix6 normal = jacobian_.transpose() * jacobian_ +
                     (lambda_ * lambda_ + damping) * Matrix6::Identity();
    Vector6 right = jacobian_.transpose() * error_ - lambda_ * lambda_ * (q_ - start_);
    if (held_ != kNoJoint) {
      normal.row(held_).setZero();
      normal.col(held_).setZero();
      normal(held_, held_) = 1;
      right[held_] = 0;
    }
    JointVector change = normal.ldlt().solve(right);
    const double largest = change.cwiseAbs().maxCoeff();
    if (largest > kLargestStep) change *= kLargestStep / largest;
    return change;
  }

  void find() {
    take(start_);
    double cost = error_.squaredNorm(), damping = 1e-12;
    for (int k = 0; k < 200 && damping < 1e3; ++k) {
      if (lambda_ == 0 && is_within(error_, kReached)) break;
      const JointVector change = step(damping);
      if (change.cwiseAbs().maxCoeff() < 1e-13) break;
      const double next = cost_at(q_ + change);
      if (next >= cost) {
        damping *= 10;
        continue;
      }
      take(q_ + change);
      cost = next;
      damping = std::max(0.1 * damping, 1e-15);
    }
  }

  const ProgramArm& arm_;
  Context context_;
  const Pose& wanted_;
  const JointVector& start_;
  double lambda_;
  int held_;
  JointVector q_;
  Vector6 error_;
  JointJacobian jacobian_;
};

bool is_near_singular(const ProgramArm& arm, Context context, const JointVector& q) {
  if (wrist_sine(arm.chain(), q) < std::sin(kNearWrist)) return true;
  JointJacobian jacobian;
  context.q = q;
  arm.pose(context, jacobian);
  jacobian.bottomRows<3>() *= kLength;
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(jacobian.transpose() * jacobian,
                                                      Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[0])) < 0.5 * kNearAny;
}

}  // namespace

JointCorrection joints_of_pose(const ProgramArm& arm, const Context& context, const Pose& wanted,
                               const JointVector& start) {
  const Minimum found(arm, context, wanted, start, 0, kNoJoint);
  return {found.q(), found.is_reached(kGoodEnough), false};
}

JointCorrection correct_joints(const ProgramArm& arm, const Context& context, const Pose& wanted,
                               const JointVector& programmed, const ChainEvaluator& controller) {
  const Branch branch = branch_of(controller, programmed);
  const auto stays = [&](const JointVector& q) {
    return is_same(branch, branch_of(controller, q));
  };
  const auto is_small = [&](const JointVector& q) {
    return (q - programmed).cwiseAbs().maxCoeff() <= kMaxSingularChange;
  };
  const JointCorrection exact = joints_of_pose(arm, context, wanted, programmed);
  const bool is_near = is_near_singular(arm, context, programmed);
  if (!exact.is_reached && !is_near) return exact;
  if (exact.is_reached && stays(exact.q) && (!is_near || is_small(exact.q))) return exact;

  const bool crosses_wrist =
      branch.wrist * branch_of(controller, exact.q).wrist < 0 || branch.wrist == 0;
  const int held = crosses_wrist ? kWristJoint : kNoJoint;
  double low = -8, high = 2;  // log10 of lambda; above 10 nothing moves
  JointVector best = programmed;
  for (int k = 0; k < 30; ++k) {
    const double middle = 0.5 * (low + high);
    const Minimum damped(arm, context, wanted, programmed, std::pow(10.0, middle), held);
    const bool is_good = is_small(damped.q()) && stays(damped.q());
    if (is_good) best = damped.q();
    (is_good ? high : low) = middle;
  }
  return {best, true, true};
}

}  // namespace armtrue
