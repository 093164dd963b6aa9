#pragma once

#include <string>
#include <vector>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// Sizes of a robot file that no arm, no ball and no artefact has, as sentences: those of most that
/// are given in m under a name in mm.
std::vector<std::string> doubts_of_sizes(const KinematicChain& chain);

}  // namespace armtrue
