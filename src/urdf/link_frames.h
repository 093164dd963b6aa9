#pragma once

#include <Eigen/Core>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// The frame of a link in the frame before it, where the joint angle is 0.
Pose link_transform(const Link& link);

/// The rotation by beta and alpha, which stands before d and theta.
Eigen::Matrix3d rotation_before(const Link& link);

/// Roll, pitch and yaw of a URDF, where R = Rz(yaw) Ry(pitch) Rx(roll): KUKA's C, B and A. Near a
/// pitch of 90 deg, roll and yaw can hardly be separated; there the roll compensates the rounding
/// of the yaw, so that R is exact to the last digits.
Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& rotation);

/// The axis of a joint where all joint angles are 0.
struct JointAxis {
  Eigen::Vector3d point, direction;
};

/// The frame on axis `own` whose x is the common normal towards `next`; source: Khalil and
/// Kleinfinger (1986). Where the axes are parallel within 0.02 rad, the origin is the foot of the
/// perpendicular from the origin of `previous` onto `own`, and x points to the foot of the
/// perpendicular from there onto `next`; source: Hayati (1983).
Pose frame_towards(const JointAxis& own, const JointAxis& next, const Pose& previous);

/// A link with theta, d and r 0, whose alpha and beta turn the z axis of the frame before to a
/// direction in that frame.
Link link_along(const Eigen::Vector3d& z);

/// Modified Denavit-Hartenberg parameters, with Hayati's beta, between two frames whose x axes
/// frame_towards() has laid.
Link link_between(const Pose& previous, const Pose& frame);

}  // namespace armtrue
