#pragma once

#include <string>
#include <vector>

#include "armtrue/path/path.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// How fast a program runs.
struct ProgramSpeed {
  double feed = 0;          ///< of the TCP between stops [m/s]
  double acceleration = 2;  ///< along the path where it starts and stops [m/s^2]
  double period = 16e-3;    ///< between two samples [s]
  double standstill = 1;    ///< before and after the motion [s]
};

/// A program as a path in time, in the frame of the program.
struct TimedProgram {
  Path path;
  std::vector<std::string> warnings;
};

/// The longest run of straight and circular moves of a program at a constant feed. The arm stops
/// where the program does not approximate (ProgramTarget::is_passed or a blend); elsewhere it keeps
/// the feed through the point, which lies on the path. Each point of the program is a sample. The
/// path has orientations if all its points state them. Warnings name what is left out: other runs,
/// with the line of the move that parts them, and further turns of a loop. Throws InputError if no
/// such move can be followed.
TimedProgram timed_path(const RobotProgram& program, const ProgramSpeed& speed);

}  // namespace armtrue
