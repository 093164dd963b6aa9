#pragma once

#include <string>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// The targets of a robot program as compensate() takes them. A target whose program names no frame
/// or tool has that of the options. Throws InputError if a frame or tool of a Cartesian target is
/// only named.
Program program_targets(const RobotProgram& program, const CompensationOptions& options);

/// The commands that rewrite() takes, one for each target.
struct ProgramCommands {
  std::vector<ProgramCommand> list;
  std::vector<std::string> warnings;
};

/// Notes of turns that this program does not state are taken off. A FANUC target whose corrected
/// joints leave the turns that its CONFIG states stays as programmed.
ProgramCommands program_commands(const RobotProgram& program,
                                 std::vector<CorrectedTarget>& targets);

}  // namespace armtrue
