#pragma once

#include <Eigen/Core>

namespace armtrue {

/// A rigid displacement `a_from_b`: the position and orientation of frame b seen from frame a.
/// Lengths in m. Products read as a chain: `a_from_c = a_from_b * b_from_c`.
struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

inline Pose operator*(const Pose& a_from_b, const Pose& b_from_c) {
  return {a_from_b.rotation * b_from_c.rotation,
          a_from_b.rotation * b_from_c.translation + a_from_b.translation};
}

/// Transforms a point from the coordinates of frame b to those of frame a.
inline Eigen::Vector3d operator*(const Pose& a_from_b, const Eigen::Vector3d& point_in_b) {
  return a_from_b.rotation * point_in_b + a_from_b.translation;
}

/// Returns b_from_a.
inline Pose inverse(const Pose& a_from_b) {
  return {a_from_b.rotation.transpose(), -(a_from_b.rotation.transpose() * a_from_b.translation)};
}

/// Returns the rotation of the KUKA angles [rad]: R = Rz(a) Ry(b) Rx(c).
Eigen::Matrix3d rotation_from_abc(double a, double b, double c);

/// Returns the KUKA angles (a, b, c) [rad] of a rotation, b in [-pi/2, pi/2].
/// At b = +-pi/2 only a -+ c is defined; c is then 0.
Eigen::Vector3d abc_from_rotation(const Eigen::Matrix3d& rotation);

/// Returns exp([w]x): the rotation about w by the angle |w| [rad].
Eigen::Matrix3d rotation_exp(const Eigen::Vector3d& w);

/// Returns the rotation vector of a rotation [rad], norm in [0, pi]. At exactly pi both signs
/// are valid: the component with the largest diagonal element of `rotation` is then positive.
Eigen::Vector3d rotation_log(const Eigen::Matrix3d& rotation);

/// Returns the rotation by the smallest angle that turns `from` into the direction of `to`.
/// Opposite directions have no unique axis; any is taken. Neither vector may be zero.
Eigen::Matrix3d shortest_rotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// Returns [v]x, so that cross_matrix(v) * u == v.cross(u).
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v);

/// Returns Jr^-1(w) of SO(3): log(exp(w) exp(e)) = w + Jr^-1(w) e + O(e^2). The residual
/// w = log(R_read R_model^T) needs it: R_model <- exp(e) R_model changes w by -Jr^-1(w) e.
Eigen::Matrix3d inverse_right_jacobian(const Eigen::Vector3d& w);

}  // namespace armtrue
