#pragma once

#include <Eigen/Core>

#include "armtrue/kinematics/pose.h"

namespace armtrue {

/// The line of sight of an instrument that measures a distance and two angles: a laser tracker, a
/// total station. Its first axis is vertical. All vectors are in R_A.
class LineOfSight {
 public:
  /// From `instrument` to `point` [m]; `up` is a unit vector.
  LineOfSight(const Eigen::Vector3d& instrument, const Eigen::Vector3d& up,
              const Eigen::Vector3d& point);

  double range() const { return range_; }  ///< [m]
  /// Angle about `up`, from the x axis of R_A, or from its y axis if x is within 37 deg of the
  /// vertical [rad].
  double azimuth() const;
  double elevation() const;  ///< [rad]
  /// Angle between the direction from the point to the instrument and `axis`, a unit vector [rad].
  double incidence(const Eigen::Vector3d& axis) const;

  /// d(reading of the point)/d(error of range, azimuth, elevation) [1, m, m]. All columns are zero
  /// for a point at the instrument. Straight above or below it those of the angles are zero.
  const Eigen::Matrix3d& derivatives() const { return derivatives_; }

 private:
  Eigen::Vector3d ray_, up_;
  double range_;
  Eigen::Matrix3d derivatives_ = Eigen::Matrix3d::Zero();
};

}  // namespace armtrue
