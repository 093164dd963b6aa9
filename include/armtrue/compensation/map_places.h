#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/compensation/error_map.h"
#include "armtrue/compensation/model_pair.h"
#include "armtrue/path/path.h"

namespace armtrue {

/// Spacing of points in a box: `count` of them along each side or, without it, at most `step` [m];
/// if both are absent, a twentieth of the longest side.
struct GridSpacing {
  std::optional<std::array<double, 3>> count;
  std::optional<double> step;
};

/// The grid of a box [m]. Throws std::invalid_argument for a count that is no whole number from 1
/// on, and for more points than memory holds.
Grid grid_of_box(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                 const GridSpacing& spacing);

/// The pose of the TCP in the program's frame by the constants of the controller's model.
Pose tcp_in_program(const Robot& controller, const CompensationOptions& options,
                    const JointVector& q);

/// The path as Cartesian targets, whose hints are its joint angles, if it has some. `orientation`:
/// of a path that states none; without it that at CompensationOptions::start or at its joint
/// angles. `source`, `lines`: of the path, for messages. Throws InputError for an orientation that
/// is stated twice or not at all, and for joint angles that put the tool elsewhere.
Program targets_of_path(const Path& path, const std::string& source, const std::vector<int>& lines,
                        const Robot& controller, const CompensationOptions& options,
                        const std::optional<Eigen::Matrix3d>& orientation);

/// Reasons to doubt a map, as sentences without a full stop.
std::vector<std::string> doubts_of_map(const ModelPair& pair, const Campaign& visits,
                                       const ErrorMap& map, const ErrorMapSummary& summary);

/// A sentence for each note that points have: how many points, and which.
std::vector<std::string> sentences_of_notes(const ErrorMap& map);

}  // namespace armtrue
