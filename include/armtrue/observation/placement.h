#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/pose.h"

namespace armtrue {

/// Base and tool that best map the arm's own points, without effects, onto the measured ones.
struct BaseAndTool {
  Pose base;                           ///< R_A from R_0
  Eigen::Matrix3Xd targets;            ///< in the last link, one column per measured target [m]
  std::vector<double> miss;            ///< of each row [m]
  std::vector<Eigen::Matrix3d> turns;  ///< of each row, the tool's rotation in the last link; empty
                                       ///< without orientations
};

/// Fits the base and the place of each target on the last link, by Levenberg and Marquardt's method
/// under Student's t with 4 degrees of freedom whose scale is the median of the misses. With the
/// rotation of the base given, all else is linear:
///     R_B^T measured = (R_B^T b) + p + R t
/// with p, R the pose of the last link in R_0, t the target on it. So a wrong tool in the robot
/// file does not rotate the base. Starts from the rotation of the registered base. If the median of
/// the misses stays above `good` [m], also from the best six of the 24 rotations of a cube about
/// it. Nothing without points, or if there are fewer than 9 equations more than unknowns.
std::optional<BaseAndTool> place_base_and_tool(const Robot& robot, const Campaign& campaign,
                                               double good);

/// The 24 rotations that map coordinate axes onto coordinate axes: starts of a fit whose rotation
/// is not known.
std::vector<Eigen::Matrix3d> turns_of_a_cube();

/// A robust mean of rotations, and the median angle to it [rad]. Of the first nine rotations, the
/// one with the smallest median angle to all is the start; the mean is of those within twice this
/// median.
std::pair<Eigen::Matrix3d, double> common_turn(const std::vector<Eigen::Matrix3d>& turns);

/// The robot with that base, and with the tool that best fits the places of the targets. The
/// rotation of the tool comes from the orientations, else from three targets or more, else it
/// stays.
Robot placed_robot(const Robot& robot, const Campaign& campaign, const BaseAndTool& placement);

}  // namespace armtrue
