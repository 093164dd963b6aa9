#pragma once

#include "armtrue/kinematics/evaluator.h"
#include "armtrue/kinematics/units.h"
#include "compensation/program_arm.h"

namespace armtrue {

/// Largest change of a joint near a singular posture [rad]. There the exact correction may turn
/// axes 4 and 6 by tens of degrees against each other for some 0.1 mrad of the tool.
inline constexpr double kMaxSingularChange = 1.0 * kDegree;

/// A wrist stretched within this angle counts as singular, whatever the correction is [rad].
inline constexpr double kStretchedWrist = 0.1 * kDegree;

/// A pose counts as reached within this [m], [rad]: 1e-6 mm.
inline constexpr double kGoodEnough = 1e-9;

struct JointCorrection {
  JointVector q;            ///< encoder angles [rad]
  bool is_reached = false;  ///< within kGoodEnough, damped, or as near as fewer axes come
  bool is_damped = false;  ///< the pose is not reached, because the change of the joints is limited
  /// The arm has fewer than six axes, and this is as near as they come.
  bool is_nearest = false;
};

/// Largest angle between the orientation of a target and those that an arm of fewer than six axes
/// can have [rad]: frames of programs are measured to lie flat within that; more is another target.
inline constexpr double kBesideAxes = 1.0 * kDegree;

/// Whether the arm has fewer axes than a pose has coordinates, those that are held not counted.
bool has_fewer_axes(const ProgramArm& arm);

/// Joint angles near `start` at which the arm has the pose R_0 from TCP; see correct_joints() for
/// the equation. On any branch. An arm of fewer than six axes gets the position, and the nearest
/// orientation within kBesideAxes.
JointCorrection joints_of_pose(const ProgramArm& arm, const Context& context, const Pose& wanted,
                               const JointVector& start);

/// Where start k = 1, 2, ... of a search lies in the range of a joint, in [0, 1): the fractional
/// part of k sqrt(2 + joint) + joint / 2. Any number of starts fills the ranges evenly.
double share_of_start(int k, int joint);

/// Joint angles at which the arm has the pose R_0 from TCP that the controller commands by
/// `programmed`. Minimises
///     |e_p|^2 + L^2 |e_r|^2 + lambda^2 |q - programmed|^2,    L = 0.1 m,
/// with e_p, e_r the errors of position and rotation; lambda = 0 unless that leaves the branch, or
/// moves a joint by too much near a singular posture: kMaxSingularChange / (1 - u^2), u from 0 at
/// the posture to 1 where the wrist is bent by 3 deg. Then lambda is the smallest that does neither
/// (damped least squares; Nakamura and Hanafusa 1986), with joint 5 fixed if the result is then
/// nearer, as when the exact correction would bend the wrist to the other side. `controller`
/// defines the branch.
///
/// An arm of fewer than six axes cannot have every pose. It gets, of all joint angles with the
/// least error of position, those with the least error of orientation (task priority; Nakamura,
/// Hanafusa and Yoshikawa 1987).
JointCorrection correct_joints(const ProgramArm& arm, const Context& context, const Pose& wanted,
                               const JointVector& programmed, const ProgramArm& controller);

}  // namespace armtrue
