#include "armtrue/effects/line_of_sight.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace armtrue {

using Eigen::Vector3d;

LineOfSight::LineOfSight(const Vector3d& instrument, const Vector3d& up, const Vector3d& point)
    : ray_(point - instrument), up_(up), range_(ray_.norm()) {
  if (range_ == 0) return;
  const Vector3d along = ray_ / range_;
  derivatives_.col(0) = along;
  derivatives_.col(1) = up.cross(ray_);
  const Vector3d upwards = up - along * along.dot(up);
  if (upwards.norm() > 0) derivatives_.col(2) = range_ * upwards.normalized();
}

double LineOfSight::azimuth() const {
  // The axis does not depend on which of x and y is nearer to the horizontal: with R_A upright both
  // are horizontal, and a fit that tilts the base a little would turn the azimuth by 90 deg.
  constexpr double kUpright = 0.8;  // cosine of 37 deg
  const Eigen::Index axis = std::abs(up_.x()) < kUpright ? 0 : 1;
  const Vector3d zero = Vector3d::Unit(axis) - up_ * up_[axis];
  return std::atan2(up_.cross(zero).dot(ray_), zero.dot(ray_));
}

double LineOfSight::elevation() const {
  const double height = ray_.dot(up_);
  return std::atan2(height, (ray_ - height * up_).norm());
}

double LineOfSight::incidence(const Vector3d& axis) const {
  return std::acos(std::clamp(range_ > 0 ? -ray_.dot(axis) / range_ : 1.0, -1.0, 1.0));
}

}  // namespace armtrue
