#pragma once

#include <Eigen/Core>

namespace armtrue {

/// Finds the places of points on a polygon (3 x n, n >= 2) that passes them in their order. A place
/// is the index of a vertex plus the fraction of the segment after it; NaN: no place. Places never
/// decrease. Among all such choices, this one maximises the
///     sum over the points with a place of 1 - (distance / tolerance)^2.
/// So a polygon may cross or repeat itself. Lengths in m.
Eigen::VectorXd places_in_order(const Eigen::Matrix3Xd& polygon, const Eigen::Matrix3Xd& points,
                                double tolerance);

/// The value of `samples` at a place, linear between two columns.
Eigen::Vector3d at_place(const Eigen::Matrix3Xd& samples, double place);

struct NearestPoint {
  Eigen::Index point = -1;
  double distance = 0;  ///< [m]
};

/// The point nearest to the polygon; `points` has at least one column.
NearestPoint nearest_to(const Eigen::Matrix3Xd& polygon, const Eigen::Matrix3Xd& points);

}  // namespace armtrue
