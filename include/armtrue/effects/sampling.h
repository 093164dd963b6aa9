#pragma once

#include <vector>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// `count` joint vectors that fill the travel of the joints evenly (Halton sequence, the same in
/// every call). Joints without limits move within +-180 deg.
std::vector<JointVector> sample_joint_space(const KinematicChain& chain, int count);

}  // namespace armtrue
