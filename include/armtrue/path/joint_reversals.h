#pragma once

#include <vector>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// A joint that turns back.
struct JointReversal {
  double time;  ///< [s]
  int joint;    ///< row of the encoder values
};

/// All of them along a path, in the order of time. A joint that goes back by less than 0.01 deg
/// shows no direction, and is none. `q`: encoder values at the times.
std::vector<JointReversal> joint_reversals(const Eigen::VectorXd& time, const JointMatrix& q);

}  // namespace armtrue
