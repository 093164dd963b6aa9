#include "armtrue/kinematics/inverse.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/joint_iterations.h"

namespace armtrue {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kTolerance = 1e-10;  // [m], [rad]

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
    const Link& link = chain.links[j];
    if (is_driven(link)) columns.col(joint++) = link.sign * jacobian.col(zero_of_link(chain, j));
  }
  return columns;
}

// Levenberg's step.
template <int kJoints>
JointVector step_towards(const JointColumns<kJoints>& columns, const Vector6& twist,
                         double damping) {
  if (columns.cols() > columns.rows()) return smallest_step(columns, twist, damping);
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

// The squared norm of the pose error [m, rad], for levenberg().
template <int kJoints>
class PoseError {
 public:
  PoseError(const KinematicChain& chain, const Pose& wanted, const JointVector& start)
      : chain_(chain), wanted_(wanted), evaluator_(chain), q_(start) {
    twist_ = miss(wanted_, evaluator_.pose(q_, jacobian_));
    columns_ = joint_columns<kJoints>(chain_, jacobian_);
  }

  double cost() const { return twist_.squaredNorm(); }
  bool is_solved() const { return is_small(twist_); }
  JointVector step(double damping) const {
    return step_towards<kJoints>(columns_, twist_, damping);
  }

  double try_step(const JointVector& step) {
    tried_twist_ = miss(wanted_, evaluator_.pose(q_ + step, jacobian_));
    return tried_twist_.squaredNorm();
  }

  void accept(const JointVector& step) {
    q_ += step;
    twist_ = tried_twist_;
    columns_ = joint_columns<kJoints>(chain_, jacobian_);
  }

  InverseResult result() const {
    return {q_, twist_.head<3>().norm(), twist_.tail<3>().norm(), is_solved()};
  }

 private:
  const KinematicChain& chain_;
  const Pose& wanted_;
  ChainEvaluator evaluator_;
  JointVector q_;
  Vector6 twist_, tried_twist_;
  PoseJacobian jacobian_;  // where a step was tried last
  JointColumns<kJoints> columns_;
};

template <int kJoints>
InverseResult solve_from(const KinematicChain& chain, const Pose& a_from_measured,
                         const JointVector& start) {
  PoseError<kJoints> error(chain, a_from_measured, start);
  levenberg(error, {.max_steps = 100, .first_damping = 1e-6, .max_damping = 1e6});
  return error.result();
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
    for (int j = 0; j < joint_count(chain); ++j) {
      const Link& link = joint_link(chain, j);
      double& q = found.q[j];
      const double centre = middle(link);
      if (!is_prismatic(link)) q = centre + std::remainder(q - centre, 2 * std::numbers::pi);
    }
    if (!chain.couplings.empty())  // a joint may follow a turn by a part of one
      found = inverse_kinematics(chain, a_from_measured, found.q);
    if (!found.reached || beyond_travel(chain, found.q)) continue;
    double distance = 0;
    for (int j = 0; j < joint_count(chain); ++j)
      distance = std::max(distance, std::abs(found.q[j] - middle(joint_link(chain, j))));
    if (best && distance >= least) continue;
    best = found.q;
    least = distance;
  }
  return best;
}

}  // namespace armtrue
