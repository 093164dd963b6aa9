#pragma once

#include "armtrue/kinematics/chain.h"
#include "armtrue/statistics/random.h"

namespace armtrue {

/// Joint values anywhere in the travel of the driven joints [rad or m].
inline JointVector random_joints(const KinematicChain& chain, Random& random) {
  JointVector q(joint_count(chain));
  for (int j = 0; j < std::ssize(q); ++j) {
    const auto [min, max] = travel(joint_link(chain, j));
    q[j] = random.uniform(min, max);
  }
  return q;
}

}  // namespace armtrue
