#pragma once

#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// Reads a program of PolyScope; see Dialect::parse().
void parse_polyscope_program(RobotProgram& program, const KnownFrames& known);

}  // namespace armtrue
