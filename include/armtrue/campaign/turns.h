#pragma once

#include <string>
#include <vector>

#include "armtrue/kinematics/chain.h"
#include "armtrue/kinematics/joint_names.h"
#include "armtrue/kinematics/joint_rows.h"

namespace armtrue {

/// Encoder values of one joint that were moved by whole turns.
struct MovedByTurns {
  int joint = 0;        ///< 0-based
  int rows = 0;         ///< number of those that were moved
  int first = 0;        ///< one of them, an index into the values
  double as_given = 0;  ///< its value before [rad]
  double as_read = 0;   ///< and after
};

/// Many controllers count angles within one turn, from 0 to 360 deg, which reads -1 deg as 359.
/// Moves such values of revolute joints by one turn into the travel of the joint, which is +-180
/// deg where the robot file states none. The values of a joint stay as they are if they span more
/// than one turn, because they then count turns; if none that a turn brings into the travel is more
/// than 30 deg outside it; or if the travel is not stated, and the values of all such joints lie
/// closer together as they are. A value within the travel stays. Then values of one pose that
/// differ by a whole turn, as at the ends of +-180 deg, become one, if the travel is at most one
/// turn.
/// `pose`: number of the pose of each value, or empty.
std::vector<MovedByTurns> move_into_travel(JointRows& q, const std::vector<int>& pose,
                                           const KinematicChain& chain);

/// What was moved, for a message: "3 angles of q4_deg, q6_deg are read ...". `lines`: of the values
/// in their file. `moved` is not empty.
std::string moved_text(const std::vector<MovedByTurns>& moved, const std::vector<JointName>& joints,
                       const std::vector<int>& lines);

/// Whether a joint turns, and its travel is at most one turn: two angles a turn apart are then one
/// place.
bool is_within_one_turn(const Link& link);

}  // namespace armtrue
