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
  Eigen::Matrix3Xd targets;            ///< in R_7, one column per target that was measured [m]
  std::vector<double> miss;            ///< of each row [m]
  std::vector<Eigen::Matrix3d> turns;  ///< of each row, its tool's rotation in R_7; or empty
};

/// Fits the base and the place of each target on the last link, by Levenberg and Marquardt's method
/// under Student's t with 4 degrees of freedom whose scale is the median of the misses. With the
/// rotation of the base given, all else is linear:
///     R_B^T measured = (R_B^T b) + p + R t
/// with p, R the pose of the last link in R_0, t the target on it. So a wrong tool in the robot
/// file does not rotate the base. Starts from the rotation of the registered base and, if the
/// misses stay above `good`, from the 24 rotations of a cube about it. Nothing without points, or
/// if there are fewer than 9 equations more than unknowns.
std::optional<BaseAndTool> place_base_and_tool(const Robot& robot, const Campaign& campaign,
                                               double good);

/// The 24 turns that map axes onto axes: starts of a fit whose rotation is not known.
std::vector<Eigen::Matrix3d> turns_of_a_cube();

/// The mean of most of `turns`, and the median angle to it [rad]. Of the first nine, the one with
/// the smallest median angle to all is the start; the mean is of those within twice this median.
std::pair<Eigen::Matrix3d, double> common_turn(const std::vector<Eigen::Matrix3d>& turns);

/// The robot with that base, and with the tool that best fits the places of the targets. The
/// rotation of the tool comes from the orientations, else from three targets or more, else it
/// stays.
Robot placed_robot(const Robot& robot, const Campaign& campaign, const BaseAndTool& placement);

}  // namespace armtrue
