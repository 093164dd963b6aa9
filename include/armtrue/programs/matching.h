#pragma once

#include <Eigen/Core>

namespace armtrue {

/// Where points lie on a polygon (3 x n, n >= 2) that is run through in their order: for each
/// column of `points` a vertex index with its fraction, or NaN for a point that has no place. The
/// places never go back; among all such choices this one has the greatest sum of 1 - (distance /
/// tolerance)^2, so that a polygon that crosses or repeats itself is no obstacle. Lengths in m.
Eigen::VectorXd places_in_order(const Eigen::Matrix3Xd& polygon, const Eigen::Matrix3Xd& points,
                                double tolerance);

/// The column of `samples` at a place, linear between two of them.
Eigen::Vector3d at_place(const Eigen::Matrix3Xd& samples, double place);

struct NearestPoint {
  Eigen::Index point = -1;
  double distance = 0;  ///< [m]
};

/// The one of `points` (at least one) that is nearest to the polygon.
NearestPoint nearest_to(const Eigen::Matrix3Xd& polygon, const Eigen::Matrix3Xd& points);

}  // namespace armtrue
