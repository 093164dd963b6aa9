#pragma once

#include <functional>
#include <string>
#include <vector>

#include "armtrue/compensation/program_targets.h"
#include "armtrue/programs/robot_program.h"
#include "command_line.h"
#include "robot_program_files.h"

namespace armtrue::app {

/// A folder of programs that are corrected together, such as a backup.
struct ProjectFiles {
  std::string folder, out;  ///< empty: none is given
  /// --base, --tool are given: of the moves for which a program states none.
  bool has_base = false, has_tool = false;
};

/// --project and --project-out.
void add_project(Command& command, ProjectFiles& files);

/// The commands for a program of it.
struct ProjectCommands {
  ProgramCommands commands;
  CorrectedMoves moves;
};

/// The postures in which others of the folder call a program.
struct PosturesAtCalls {
  std::vector<JointVector> angles;  ///< as ProgramCommand::programmed; none: not all are known
  std::string callers;              ///< `a.src:12, b.src:7`
};
/// The commands for a program of a folder; the second argument tells how others of it call the
/// program. Throws InputError where that cannot be done.
using CommandsFor =
    std::function<ProjectCommands(RobotProgram&, const std::function<PosturesAtCalls()>&)>;

/// Corrects every program of the folder that moves the arm by `commands_for`; where it throws
/// InputError, the program stays. Writes all files of the folder into --project-out, and a table of
/// the programs to -o: program, moves, corrected, left, why. Returns whether every move is
/// corrected. Throws CorrectedAlready if one of the programs is.
bool correct_project(Command& command, const ProjectFiles& project, const RobotProgramFiles& files,
                     const CommandsFor& commands_for);

}  // namespace armtrue::app
