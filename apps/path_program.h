#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "armtrue/kinematics/units.h"
#include "armtrue/path/path.h"
#include "armtrue/programs/displacement.h"
#include "armtrue/programs/robot_program.h"
#include "command_line.h"

namespace armtrue::app {

/// Options of a program that is displaced with a path.
struct PathProgramArguments {
  std::string path;  ///< empty: none is given
  std::string out;
  std::vector<std::string> with;  ///< files and folders that declare what the program uses
  double spacing_mm = DisplacementOptions{}.spacing / kMillimetre;
};

/// --program, --program-out, --with, --spacing-mm.
void add_path_program(Command& command, PathProgramArguments& arguments);

/// Reads a program for its positions, with what the files and folders of `with` declare. Throws
/// InputError, with the remedy, if it bears the mark of mirror-correct.
RobotProgram read_original_program(Command& command, const std::string& path,
                                   const std::vector<std::string>& with, const char* remedy);

/// The same, and checks that the corrected program can be written where it shall be.
RobotProgram read_path_program(Command& command, const PathProgramArguments& arguments);

/// Displaces the program as `corrected` displaces the path, writes it and tells what was done.
/// Throws InputError if it lies on that path, or on the one that ran before, instead of the
/// programmed one: then it is corrected already.
void write_path_program(Command& command, const PathProgramArguments& arguments,
                        const RobotProgram& program, const Path& programmed,
                        const Eigen::Matrix3Xd& corrected,
                        const std::optional<Eigen::Matrix3Xd>& previous);

}  // namespace armtrue::app
