#pragma once

#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// See parse_program(). The texts of the program are there; the parser fills the rest.
void parse_inform_program(RobotProgram& program, const KnownFrames& known, TargetParts parts);

}  // namespace armtrue
