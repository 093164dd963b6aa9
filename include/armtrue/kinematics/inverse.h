#pragma once

#include <optional>
#include <vector>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// Where the search for joint angles ended.
struct InverseResult {
  JointVector q;                 ///< encoder angles [rad]; travel limits are not regarded
  double position_error = 0;     ///< what is left [m]
  double orientation_error = 0;  ///< what is left [rad]
  bool reached = false;          ///< both below 1e-10
};

/// Encoder angles at which the measured frame takes the pose `a_from_measured`: the solution near
/// `start`, of the same branch. Newton's method with Levenberg's damping on the analytic Jacobian;
/// far from a pose that cannot be reached it ends at the least error it finds.
InverseResult inverse_kinematics(const KinematicChain& chain, const Pose& a_from_measured,
                                 const JointVector& start);

/// The same from several starts: of the solutions within the travel of the joints the one nearest
/// to its middle, whole turns taken out; nothing if no start leads to one.
std::optional<JointVector> inverse_kinematics(const KinematicChain& chain,
                                              const Pose& a_from_measured,
                                              const std::vector<JointVector>& starts);

/// The first joint (0-based) that stands outside its travel; -1 if none does.
int joint_beyond_travel(const KinematicChain& chain, const JointVector& q);

}  // namespace armtrue
