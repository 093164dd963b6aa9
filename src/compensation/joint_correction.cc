#include "compensation/joint_correction.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "armtrue/calibration/constants_fit.h"
#include "armtrue/kinematics/joint_iterations.h"
#include "compensation/branch.h"

namespace armtrue {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kLength = kLengthOfTurn;
constexpr double kReached = 1e-10;    // [m], [rad]
// Share of the largest motion, and of a joint's own turn: less of it in some direction is due to
// the errors of axes alone, some mrad.
constexpr double kOwnMotion = 1e-2;
constexpr int kPoseCoordinates = 6;
constexpr int kNoJoint = -1, kWristJoint = 4;
// With a wrist bent by less, or another singular value as small, a posture is near a singular one.
constexpr double kNearWrist = 3 * kDegree;
constexpr double kNearAny = 0.5 * kLength * kNearWrist;  // of the least singular value

// Position and rotation error of `reached` against `wanted`; the rotation times kLength [m].
Vector6 weighted_error(const Pose& wanted, const Pose& reached) {
  Vector6 error;
  error << wanted.translation - reached.translation,
      kLength * rotation_log(wanted.rotation * reached.rotation.transpose());
  return error;
}

bool is_within(const Vector6& error, double tolerance) {
  return error.head<3>().norm() < tolerance && error.tail<3>().norm() < kLength * tolerance;
}

// (J^T J + weight I)^-1 right for six joints, with one held or kNoJoint.
JointVector solve_six(const Eigen::Matrix<double, 6, 6>& jacobian, double weight,
                      const Vector6& right_side, int held) {
  Matrix6 normal = jacobian.transpose() * jacobian + weight * Matrix6::Identity();
  Vector6 right = right_side;
  if (held != kNoJoint) {
    normal.row(held).setZero();
    normal.col(held).setZero();
    normal(held, held) = 1;
    right[held] = 0;
  }
  const Vector6 change = normal.ldlt().solve(right);
  return change;
}

// The same for any number, none of them held.
JointVector solve_any(const JointJacobian& jacobian, double weight, const JointVector& right) {
  const Eigen::MatrixXd normal =
      jacobian.transpose() * jacobian +
      weight * Eigen::MatrixXd::Identity(jacobian.cols(), jacobian.cols());
  return normal.ldlt().solve(right);
}

double squared_norm(const JointVector& q) {
  return q.size() == 6 ? Vector6(q).squaredNorm() : q.squaredNorm();
}

// One minimisation by levenberg(), with one lambda; `held` is a joint that does not move, or
// kNoJoint.
class Minimum {
 public:
  Minimum(const ProgramArm& arm, const Context& context, const Pose& wanted,
          const JointVector& start, double lambda, int held)
      : arm_(arm), context_(context), wanted_(wanted), start_(start), lambda_(lambda), held_(held) {
    take(start_);
    levenberg(*this,
              {.max_steps = 200, .first_damping = 1e-12, .max_damping = 1e3, .least_step = 1e-13});
  }

  const JointVector& q() const { return q_; }
  bool is_reached(double tolerance) const { return is_within(error_, tolerance); }
  double error() const { return error_.norm(); }  // weighted [m]

  double cost() const {
    return error_.squaredNorm() + lambda_ * lambda_ * squared_norm(q_ - start_);
  }

  bool is_solved() const { return lambda_ == 0 && is_within(error_, kReached); }

  // With more than six joints and no lambda, one that leaves the null space alone.
  JointVector step(double damping) const {
    const double weight = lambda_ * lambda_ + damping;
    if (q_.size() == 6) {
      const Eigen::Matrix<double, 6, 6> jacobian = jacobian_;
      const Vector6 right =
          jacobian.transpose() * error_ - lambda_ * lambda_ * Vector6(q_ - start_);
      return solve_six(jacobian, weight, right, held_);
    }
    if (q_.size() > 6 && lambda_ == 0) return smallest_step(jacobian_, error_, weight);
    return solve_any(jacobian_, weight,
                     jacobian_.transpose() * error_ - lambda_ * lambda_ * (q_ - start_));
  }

  double try_step(const JointVector& step) const {
    Context context = context_;
    context.q = q_ + step;
    return weighted_error(wanted_, arm_.pose(context)).squaredNorm() +
           lambda_ * lambda_ * squared_norm(context.q - start_);
  }

  void accept(const JointVector& step) { take(q_ + step); }

 private:
  void take(const JointVector& q) {
    q_ = q;
    context_.q = q;
    error_ = weighted_error(wanted_, arm_.pose(context_, jacobian_));
    jacobian_.bottomRows<3>() *= kLength;
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

// The pseudoinverse of the motion of three coordinates by the joints, M^T (M M^T)^+, where
// directions in which the joints move by up to `noise` are none.
Eigen::MatrixXd pseudoinverse(const Eigen::MatrixXd& motion, double noise) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> square(motion * motion.transpose());
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d direction = square.eigenvectors().col(k);
    if (square.eigenvalues()[k] > noise * noise)
      inverse += direction * direction.transpose() / square.eigenvalues()[k];
  }
  return motion.transpose() * inverse;
}

// Where an arm of fewer than six axes comes nearest to a pose: the position first, and with what
// is left of its motion the orientation. Nothing if the steps do not end.
std::optional<JointVector> nearest_joints(const ProgramArm& arm, Context context,
                                          const Pose& wanted, const JointVector& start) {
  constexpr int kMostSteps = 100;
  constexpr double kStands = 1e-12;  // [rad], [m]
  return newton(start, kMostSteps, [&](const JointVector& q) -> std::optional<JointVector> {
    context.q = q;
    JointJacobian jacobian;
    const Pose reached = arm.pose(context, jacobian);
    const Eigen::MatrixXd place = jacobian.topRows<3>(), turn = jacobian.bottomRows<3>();
    const double noise = kOwnMotion * place.colwise().norm().maxCoeff();
    const Eigen::MatrixXd from_place = pseudoinverse(place, noise);
    const Eigen::VectorXd to_place = from_place * (wanted.translation - reached.translation);
    const Eigen::Vector3d turned =
        rotation_log(wanted.rotation * reached.rotation.transpose()) - turn * to_place;
    // What the joints still turn while the place stays.
    const Eigen::MatrixXd rest = turn - turn * from_place * place;
    const Eigen::VectorXd step = to_place + pseudoinverse(rest, kOwnMotion) * turned;
    if (step.cwiseAbs().maxCoeff() < kStands) return std::nullopt;
    return JointVector(step);
  });
}

// `held`: joints that stay, whose columns are zero.
double least_singular_value(const JointJacobian& jacobian, Eigen::Index held) {
  if (jacobian.cols() - held < jacobian.rows()) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
        Eigen::MatrixXd(jacobian.transpose() * jacobian), Eigen::EigenvaluesOnly);
    return std::sqrt(std::max(0.0, solver.eigenvalues()[held]));
  }
  Eigen::MatrixXd square;
  if (jacobian.cols() == 6) {
    const Matrix6 six = jacobian;
    square = six.transpose() * six;
  } else {
    square = jacobian * jacobian.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(square, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
}

// Largest change of a joint: kMaxSingularChange at a singular posture, unlimited far from it, with
// a continuous transition.
double largest_change(const ProgramArm& arm, Context context, const JointVector& q) {
  JointJacobian jacobian;
  context.q = q;
  arm.pose(context, jacobian);
  jacobian.bottomRows<3>() *= kLength;
  const double least = least_singular_value(jacobian, std::ssize(arm.held()));
  const double near = std::min(arm.wrist_sine_at(q) / std::sin(kNearWrist), least / kNearAny);
  return near < 1 ? kMaxSingularChange / (1 - near * near)
                  : std::numeric_limits<double>::infinity();
}

}  // namespace

bool has_fewer_axes(const ProgramArm& arm) {
  return joint_count(arm.robot().chain) - std::ssize(arm.held()) < kPoseCoordinates;
}

JointCorrection joints_of_pose(const ProgramArm& arm, const Context& context, const Pose& wanted,
                               const JointVector& start) {
  if (has_fewer_axes(arm)) {
    const std::optional<JointVector> nearest = nearest_joints(arm, context, wanted, start);
    if (!nearest) return {start, false, false};
    Context there = context;
    there.q = *nearest;
    const PoseDifference left = difference(wanted, arm.pose(there));
    return {*nearest, left.position < kGoodEnough && left.orientation < kBesideAxes, false};
  }
  const Minimum found(arm, context, wanted, start, 0, kNoJoint);
  return {found.q(), found.is_reached(kGoodEnough), false};
}

double share_of_start(int k, int joint) {
  return std::fmod(k * std::sqrt(2.0 + joint) + 0.5 * joint, 1.0);
}

JointCorrection correct_joints(const ProgramArm& arm, const Context& context, const Pose& wanted,
                               const JointVector& programmed, const ProgramArm& controller) {
  const Branch branch = controller.branch_at(programmed);
  const double most = largest_change(arm, context, programmed);
  const auto is_good = [&](const JointVector& q) {
    return (q - programmed).cwiseAbs().maxCoeff() <= most && stays(branch, controller.branch_at(q));
  };
  if (has_fewer_axes(arm)) {
    const std::optional<JointVector> nearest = nearest_joints(arm, context, wanted, programmed);
    if (nearest && is_good(*nearest)) return {*nearest, true, false, true};
    if (!nearest && std::isinf(most)) return {programmed, false, false};
  } else {
    const Minimum exact(arm, context, wanted, programmed, 0, kNoJoint);
    const bool is_reached = exact.is_reached(kGoodEnough);
    if (is_reached && is_good(exact.q())) return {exact.q(), true, false};
    if (!is_reached && std::isinf(most)) return {exact.q(), false, false};
  }

  JointCorrection best{programmed, true, true};
  double least = std::numeric_limits<double>::infinity();
  for (int held : {kNoJoint, kWristJoint}) {
    if (held != kNoJoint && !arm.chain().is_six_axis_arm()) continue;
    double low = -8, high = 2;  // log10 of lambda; above 10 nothing moves
    for (int k = 0; k < 30; ++k) {
      const double middle = 0.5 * (low + high);
      const Minimum damped(arm, context, wanted, programmed, std::pow(10.0, middle), held);
      const bool take = is_good(damped.q());
      (take ? high : low) = middle;
      if (!take || damped.error() >= least) continue;
      least = damped.error();
      best.q = damped.q();
    }
  }
  return best;
}

}  // namespace armtrue
