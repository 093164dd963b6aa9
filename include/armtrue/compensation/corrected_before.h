#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/compensation/program_joints.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// Evidence that targets are already commands of compensate() for these two models, without a mark
/// or check digits. Programmed numbers have few decimals, commands many. The identified arm takes a
/// command to the programmed target: numbers that are long as written are short there, up to the
/// rounding of the command. For a target that is not corrected it is the other way round, so it
/// never counts.
struct RoundWhereReached {
  int decimals = 0;  ///< of the numbers that the identified arm reaches
  int numbers = 0;   ///< numbers that have more decimals as written, and differ in these
  int round = 0;     ///< numbers of these that are short where the arm takes them
  int target = 0;    ///< row of one of them
  double written = 0, reached = 0;  ///< in the unit of the program, mm and deg of a table
};

/// For a robot program and its `targets` by compensate(). Nothing if it may be chance (p > 1e-8).
std::optional<RoundWhereReached> find_round_where_reached(
    const RobotProgram& program, const std::vector<CorrectedTarget>& targets,
    const ProgramJoints& joints);

/// For a table of the robot `controller`, by its poses and by its joint angles.
std::optional<RoundWhereReached> find_round_where_reached(
    const Robot& controller, const std::vector<CorrectedTarget>& targets);

}  // namespace armtrue
