#pragma once

// A frame of the oracle as a matrix of numbers with derivatives, beside a column of the Jacobian.

#include <Eigen/Core>

#include "armtrue/kinematics/pose.h"

namespace armtrue {

inline Eigen::Matrix4d homogeneous(const Pose& pose) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = pose.rotation;
  m.topRightCorner<3, 1>() = pose.translation;
  return m;
}

/// The twist by the k-th variable: how the origin moves, then how the axes turn.
template <typename Frame>
Eigen::Matrix<double, 6, 1> twist_by(const Frame& frame, int k) {
  Eigen::Matrix<double, 6, 1> twist;
  Eigen::Matrix3d r, dr;
  for (int row = 0; row < 3; ++row) {
    twist[row] = frame(row, 3).v[k];
    for (int c = 0; c < 3; ++c) {
      r(row, c) = frame(row, c).a;
      dr(row, c) = frame(row, c).v[k];
    }
  }
  const Eigen::Matrix3d spin = dr * r.transpose();
  twist.tail<3>() << spin(2, 1), spin(0, 2), spin(1, 0);
  return twist;
}

}  // namespace armtrue
