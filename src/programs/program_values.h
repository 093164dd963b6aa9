#pragma once

#include <string>
#include <vector>

#include "armtrue/programs/robot_program.h"

// The numbers of each dialect as poses and joint angles, and back.

namespace armtrue {

/// The pose of the six numbers (seven of RAPID, whose quaternion need not have the length 1).
Pose pose_of_numbers(Dialect dialect, const std::vector<double>& numbers);

/// The numbers of a pose. Of the angles that give the same rotation those next to `written`.
std::vector<double> numbers_of_pose(Dialect dialect, const Pose& pose,
                                    const std::vector<double>& written);

/// The encoder angles [rad] of the model. FANUC shows joint 3 relative to the horizontal; the chain
/// counts it from the upper arm: q3 = J3 + J2 (FANUC, R-30iB operator's manual, joint coordinates).
JointVector joints_of_numbers(Dialect dialect, const std::vector<double>& numbers);
std::vector<double> numbers_of_joints(Dialect dialect, const JointVector& q);

/// ABB's cf1, cf4, cf6 and cfx of a posture (RAPID reference manual, confdata): quadrants of the
/// axes 1, 4 and 6. cfx is not among them: see configuration_numbers().
int quadrant(double angle);

/// KUKA's angles A, B, C [rad] of a rotation, those next to `near`: (a, b, c) and (a + pi, pi - b,
/// c + pi) are the same rotation, and at b = +-pi/2 only a -+ c is defined.
Eigen::Vector3d abc_near(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& near);

}  // namespace armtrue
