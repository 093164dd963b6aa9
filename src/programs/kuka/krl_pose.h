#pragma once

#include <Eigen/Core>
#include <limits>

// Poses as KRL gives them: component by component, some of them unknown.

namespace armtrue {

/// X, Y, Z [m], A, B, C [rad], E1..E6 [as written]; NaN: not given, or unknown.
inline constexpr int kKrlComponents = 12;
using KrlValues = Eigen::Matrix<double, kKrlComponents, 1>;

inline KrlValues unknown_krl_values() {
  return KrlValues::Constant(std::numeric_limits<double>::quiet_NaN());
}

/// `given`, completed by the pose before: a controller keeps the components that a frame leaves
/// out.
inline KrlValues inherit(const KrlValues& before, const KrlValues& given) {
  return given.array().isFinite().select(given, before);
}

/// The components in which two poses are equal; the others are unknown.
inline KrlValues common(const KrlValues& a, const KrlValues& b) {
  return (a.array() == b.array()).select(a, unknown_krl_values());
}

inline Eigen::Vector3d position(const KrlValues& pose) { return pose.head<3>(); }

}  // namespace armtrue
