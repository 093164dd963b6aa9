#pragma once

#include <optional>
#include <vector>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// Result of the numerical inverse kinematics.
struct InverseResult {
  JointVector q;                 ///< encoder values [rad or m]; travel limits are ignored
  double position_error = 0;     ///< remaining distance [m]
  double orientation_error = 0;  ///< remaining rotation angle [rad]
  bool reached = false;          ///< both errors are below 1e-10 [m, rad]
};

/// Finds encoder values at which the measured frame has the pose `a_from_measured`, near `start`.
/// Levenberg's method with the analytic Jacobian: dq = (J^T J + lambda I)^-1 J^T e, where e is the
/// pose error [m, rad]; each step is at most 0.3 rad or m per joint. With more than six joints the
/// same step is dq = J^T (J J^T + lambda I)^-1 e, which leaves the null space alone: among the
/// postures that reach the pose one close to `start` is found. If the pose cannot be reached, the
/// result has the smallest error found.
InverseResult inverse_kinematics(const KinematicChain& chain, const Pose& a_from_measured,
                                 const JointVector& start);

/// Searches from several starts. Whole turns of revolute joints are removed; solutions outside the
/// travel are discarded. Returns the solution with the smallest max_j |q_j - middle of travel_j|,
/// or nothing if no start leads to a solution.
std::optional<JointVector> inverse_kinematics(const KinematicChain& chain,
                                              const Pose& a_from_measured,
                                              const std::vector<JointVector>& starts);

}  // namespace armtrue
