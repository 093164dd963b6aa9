#include "armtrue/kinematics/pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace armtrue {

Eigen::Matrix3d rotation_from_abc(double a, double b, double c) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(a, Vector3d::UnitZ()) * AngleAxisd(b, Vector3d::UnitY()) *
          AngleAxisd(c, Vector3d::UnitX()))
      .toRotationMatrix();
}

Eigen::Vector3d abc_from_rotation(const Eigen::Matrix3d& rotation) {
  const double cos_b = std::hypot(rotation(0, 0), rotation(1, 0));
  const double b = std::atan2(-rotation(2, 0), cos_b);
  if (cos_b < 1e-12) return {std::atan2(-rotation(0, 1), rotation(1, 1)), b, 0.0};
  return {std::atan2(rotation(1, 0), rotation(0, 0)), b,
          std::atan2(rotation(2, 1), rotation(2, 2))};
}

Eigen::Matrix3d rotation_exp(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity() + cross_matrix(w);
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

Eigen::Vector3d rotation_log(const Eigen::Matrix3d& rotation) {
  // Small angles, as those of residuals, by the series of asin(s) / s: its next term is below the
  // last digit.
  constexpr double kSmallSquare = 1e-4;
  const Eigen::Vector3d sine_axis =
      0.5 * Eigen::Vector3d(rotation(2, 1) - rotation(1, 2), rotation(0, 2) - rotation(2, 0),
                            rotation(1, 0) - rotation(0, 1));
  const double s = sine_axis.squaredNorm();
  if (s < kSmallSquare && rotation.trace() > 1)
    return (1 + s * (1.0 / 6 + s * (3.0 / 40 + s * (5.0 / 112)))) * sine_axis;
  // The quaternion keeps full precision both at 0 and near pi.
  const Eigen::Quaterniond quaternion(rotation);
  const double sine = quaternion.vec().norm();
  if (sine < 1e-14) return 2.0 * quaternion.vec();
  const double half_angle = std::atan2(sine, std::abs(quaternion.w()));
  return (quaternion.w() < 0 ? -2.0 : 2.0) * half_angle / sine * quaternion.vec();
}

Eigen::Matrix3d shortest_rotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized(), b = to.normalized();
  Eigen::Vector3d across = a.cross(b);
  across -= across.dot(a) * a;  // rounding, as large as `across` itself near opposite directions
  const double sine = across.norm(), angle = std::atan2(sine, a.dot(b));
  return rotation_exp(sine > 0 ? Eigen::Vector3d(angle / sine * across)
                               : Eigen::Vector3d(angle * a.unitOrthogonal()));
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d inverse_right_jacobian(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  const Eigen::Matrix3d wx = cross_matrix(w);
  // (1/t^2 - (1 + cos t) / (2 t sin t)) -> 1/12 as t -> 0
  double factor = 1.0 / 12.0;
  if (angle > 1e-4) {
    const double t =
        std::min(angle, 3.1);  // the formula is singular at pi, where no residual should stay
    factor = 1.0 / (t * t) - (1.0 + std::cos(t)) / (2.0 * t * std::sin(t));
  }
  return Eigen::Matrix3d::Identity() + 0.5 * wx + factor * wx * wx;
}

}  // namespace armtrue
