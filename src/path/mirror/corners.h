#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/path/path.h"

namespace armtrue {

/// A place where a path turns by more than 15 deg at once, with a stop or without.
struct Corner {
  Eigen::Index last;              ///< sample of the side before it
  Eigen::Vector3d vertex;         ///< where both sides meet [m]
  Eigen::Vector3d before, after;  ///< unit tangents of the sides
};

std::vector<Corner> find_corners(const Path& path);

/// tangents(), but beside a corner those of the side on which a sample lies.
Eigen::Matrix3Xd side_tangents(const Path& path, const std::vector<Corner>& corners);

/// Displacements across the path, one for each sample, leave the displaced sides apart at a corner,
/// or cross them. This moves samples along their sides, evenly more towards the corner and by no
/// more than a tenth of their distance where there is room, so that the displaced sides meet where
/// they intersect: the displacement there has the normal parts of both. As the mitre of drawn lines
/// it is limited, to twice the larger displacement: at an angle below some 50 deg a short straight
/// piece is left between the sides. What differs across the plane of a corner stays a step, and a
/// path that turns right back has no intersection.
void join_sides(const Path& path, const std::vector<Corner>& corners,
                Eigen::Matrix3Xd& displacement);

}  // namespace armtrue
