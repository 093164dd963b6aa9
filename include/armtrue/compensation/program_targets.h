#pragma once

#include <string>
#include <utility>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/compensation/program_joints.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// Converts the targets of a robot program for compensate(). If a program names no frame or tool,
/// its targets have that of the options. Throws InputError if the values of frames or tools of
/// Cartesian targets are not known, and names all of them, or if that of an external axis among the
/// joints is not.
Program program_targets(const RobotProgram& program, const CompensationOptions& options,
                        const ProgramJoints& joints);

/// The commands that rewrite() takes, one for each target.
struct ProgramCommands {
  std::vector<ProgramCommand> list;
  std::vector<std::string> warnings;
};

/// Removes notes on turns that this program does not state. If a correction takes the joints of a
/// FANUC target out of the turns that its CONFIG states, the target stays as programmed. `rows`: of
/// program_targets().
ProgramCommands program_commands(const RobotProgram& program, const Program& rows,
                                 std::vector<CorrectedTarget>& targets, const ProgramJoints& joints,
                                 const Robot& controller, const CompensationOptions& options);

/// Numbers of the moves of a program: corrected, left alone, never run.
struct CorrectedMoves {
  int all = 0, corrected = 0;  ///< of those that may run
  int never_run = 0;           ///< other moves, which no path through the program reaches
  /// Why the others are left alone, with their number, the most frequent first.
  std::vector<std::pair<std::string, int>> reasons;
  std::string sentence;
};

/// For a program whose moves are all left alone, with the reason of each.
CorrectedMoves moves_left_alone(const std::vector<std::string>& why);
/// For a program whose targets cannot be corrected.
CorrectedMoves moves_left_alone(const RobotProgram& program, const std::string& why);

/// `targets`: after program_commands().
CorrectedMoves corrected_moves(const RobotProgram& program,
                               const std::vector<CorrectedTarget>& targets);

}  // namespace armtrue
