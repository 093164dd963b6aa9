#pragma once

#include <vector>

#include "armtrue/programs/robot_program.h"
#include "programs/routine_copies.h"

namespace armtrue {

/// The subprograms of a KRL program, and with which $BASE, $TOOL and $IPO_MODE each call runs.
std::vector<Routine> krl_routines(const RobotProgram& program, const KnownFrames& known);

}  // namespace armtrue
