#pragma once

#include "armtrue/programs/robot_program.h"

// The parsers of the dialects; see parse_program().

namespace armtrue {

/// `texts` of the program are read; the parser fills the rest.
void parse_krl_program(RobotProgram& program, const KnownFrames& known, TargetParts parts);
void parse_rapid_program(RobotProgram& program, const KnownFrames& known, TargetParts parts);
void parse_fanuc_program(RobotProgram& program, const KnownFrames& known, TargetParts parts);
void parse_urscript_program(RobotProgram& program, const KnownFrames& known, TargetParts parts);

}  // namespace armtrue
