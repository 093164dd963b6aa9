#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "armtrue/kinematics/units.h"
#include "armtrue/path/path.h"
#include "armtrue/programs/krl.h"
#include "armtrue/programs/robot_program.h"
#include "command_line.h"

namespace armtrue::app {

/// Options of a program that is displaced with a path.
struct PathProgramArguments {
  std::string path;  ///< empty: none is given
  std::string out;
  double spacing_mm = DisplacementOptions{}.spacing / kMillimetre;
};

/// --program, --program-out, --spacing-mm.
void add_path_program(Command& command, PathProgramArguments& arguments);

/// A program of KUKA, or of another maker.
struct PathProgram {
  std::optional<KrlProgram> krl;
  std::optional<RobotProgram> other;
};

/// Reads the program and checks that the corrected one can be written where it shall be.
PathProgram read_path_program(Command& command, const PathProgramArguments& arguments);

/// Displaces the program as `corrected` displaces the path, writes it and tells what was done.
void write_path_program(Command& command, const PathProgramArguments& arguments,
                        const PathProgram& program, const Path& programmed,
                        const Eigen::Matrix3Xd& corrected);

}  // namespace armtrue::app
