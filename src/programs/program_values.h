#pragma once

#include <Eigen/Core>

// The angles of rotations that programs write.

namespace armtrue {

/// Angles a, b, c [rad] of R = Rz(a) Ry(b) Rx(c), those next to `near`: (a, b, c) and (a + pi, pi -
/// b, c + pi) are the same rotation, and at b = +-pi/2 only a -+ c is defined.
Eigen::Vector3d abc_near(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& near);

/// The rotation vector [rad] of a rotation, the one next to `near`: v + 2 pi k v / |v| are one
/// rotation.
Eigen::Vector3d rotation_vector_near(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& near);

}  // namespace armtrue
