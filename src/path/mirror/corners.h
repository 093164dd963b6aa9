#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/path/path.h"

namespace armtrue {

/// A place where a path turns by more than 15 deg within three samples, with a stop or without.
struct Corner {
  Eigen::Index last;              ///< sample of the side before it
  Eigen::Vector3d vertex;         ///< where both sides meet [m]
  Eigen::Vector3d before, after;  ///< unit tangents of the sides
};

std::vector<Corner> find_corners(const Path& path);

/// tangents(), but beside a corner the tangent of the side on which a sample lies.
Eigen::Matrix3Xd side_tangents(const Path& path, const std::vector<Corner>& corners);

/// Vectors, one for each sample, without their part along the path: v - (u . v) u, with u of
/// side_tangents().
Eigen::Matrix3Xd without_along(const Path& path, const std::vector<Corner>& corners,
                               Eigen::Matrix3Xd vectors);

/// Joins displaced sides at corners. Displacements across the path, one for each sample, leave a
/// gap between the sides of a corner, or make them cross. This shifts samples along their sides so
/// that the sides end where they intersect. The shift grows linearly towards the corner, over ten
/// times its size where the side is long enough. It is limited to twice the larger displacement
/// (the mitre of drawn lines): below an angle of some 50 deg a short straight piece is left between
/// the sides. A difference normal to the plane of the corner stays a step; a path that reverses
/// completely stays as it is.
void join_sides(const Path& path, const std::vector<Corner>& corners,
                Eigen::Matrix3Xd& displacement);

}  // namespace armtrue
