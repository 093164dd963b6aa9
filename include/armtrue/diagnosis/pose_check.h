#pragma once

#include <array>
#include <string>
#include <vector>

#include "armtrue/effects/robot.h"
#include "armtrue/kinematics/evaluator.h"

namespace armtrue {

/// A frame of the arm as a pendant shows it.
struct ShownFrame {
  std::string name;   ///< "flange in foot"
  std::string what;   ///< by the names of a robot file: "R_7 in R_0"
  std::string words;  ///< what pendants call it
  Pose pose;
};

/// Flange and tool in the foot R_0, and tool in R_A, at the joint angles `q` [rad]; the flange, R_7
/// of six axes, is the first. Uses the constants only, no effects.
std::vector<ShownFrame> shown_frames(const Robot& robot, const JointVector& q);

/// A pose as numbers of a pendant: x, y, z [mm], then the KUKA angles a, b, c [deg].
using PendantPose = std::array<double, 6>;

/// Changes of the robot file, the joint angles or the pose with which they agree.
struct Agreement {
  std::vector<std::string> changes;  ///< in words; empty: they agree without a change
  std::string frame;                 ///< name of the ShownFrame that agrees, and what it is
  bool is_flange = false;            ///< whether it is the flange of the robot file
  double distance = 0;               ///< [m]
  double angle = 0;                  ///< [rad]
};

/// All agreements with the fewest changes, at most two, that bring a frame within `distance` [m]
/// and `angle` [rad] of the pose, best first. Changes are: a joint with another sign or another
/// zero, angles in rad, joint 3 relative to the horizontal, a table in the standard convention, a
/// base turned about z or below the controller's frame at axis 2, other angles of orientation,
/// lengths in m; alone also a flange that is turned by right angles. Frames that are the same, as
/// with a tool of 0, count once. Empty if none does.
std::vector<Agreement> find_agreements(const Robot& robot, const JointVector& q,
                                       const PendantPose& pose, double distance, double angle);

/// Joints, as `A1`, whose sign this pose does not show: the pose agrees with the robot file and
/// with the joint turned the other way, because the joint stands at 0 or moves nothing that the
/// pose shows. Empty if the pose does not agree.
std::vector<std::string> find_unseen_signs(const Robot& robot, const JointVector& q,
                                           const PendantPose& pose, double distance, double angle);

/// A sentence for each joint beyond its travel, with its value.
std::vector<std::string> joints_beyond_travel(const KinematicChain& chain, const JointVector& q);

}  // namespace armtrue
