#pragma once

#include <string>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/compensation/program_joints.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// Converts the targets of a robot program for compensate(). If a program names no frame or tool,
/// its targets have that of the options. Throws InputError if the value of a frame or tool of a
/// Cartesian target is not known, or that of an external axis among the joints.
Program program_targets(const RobotProgram& program, const CompensationOptions& options,
                        const ProgramJoints& joints);

/// The commands that rewrite() takes, one for each target.
struct ProgramCommands {
  std::vector<ProgramCommand> list;
  std::vector<std::string> warnings;
};

/// Removes notes on turns that this program does not state. If the corrected joints of a FANUC
/// target leave the turns that its CONFIG states, the target stays as programmed.
ProgramCommands program_commands(const RobotProgram& program, std::vector<CorrectedTarget>& targets,
                                 const ProgramJoints& joints);

}  // namespace armtrue
