#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>

#include "armtrue/kinematics/chain.h"
#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/joint_iterations.h"

namespace armtrue {

/// Newton's method for the joints until a point of the arm is where it touches, from `start` by
/// smallest steps. Nothing if that is out of reach.
///     pose_at(q, jacobian)     R_A from the measured frame, and its Jacobian, which may be rough
///     point                    in the measured frame [m]
///     miss(place, gradients)   how far a point at `place` in R_A is off, one or three numbers [m],
///                              and the derivatives, a row each, by that place
template <typename PoseAt, typename Miss>
std::optional<JointVector> touching_joints(const KinematicChain& chain, const PoseAt& pose_at,
                                           const Eigen::Vector3d& point, const Miss& miss,
                                           const JointVector& start) {
  constexpr int kMaxSteps = 100;
  constexpr double kTouches = 1e-12;  // m, far below what a rank could notice
  const auto step_at = [&](const JointVector& q) -> std::optional<JointVector> {
    PoseJacobian of_pose;
    const Pose frame = pose_at(q, of_pose);
    const Eigen::Vector3d lever = frame.rotation * point;
    move_to_point(of_pose, lever);
    Eigen::Matrix3Xd joints(3, joint_count(chain));
    for (int j = 0; j < joints.cols(); ++j)
      joints.col(j) = joint_column(chain, of_pose, j).template head<3>();
    Eigen::MatrixX3d gradients;
    const Eigen::VectorXd off = miss(Eigen::Vector3d(frame.translation + lever), gradients);
    if (off.norm() < kTouches) return std::nullopt;
    const Eigen::MatrixXd jacobian = gradients * joints;
    const double damping = std::max(1e-30, 1e-12 * jacobian.squaredNorm());
    return smallest_step(jacobian, Eigen::VectorXd(-off), damping);
  };
  return newton(start, kMaxSteps, step_at);
}

}  // namespace armtrue
