#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/compensation/program_joints.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// Signs that targets are commands of compensate() for these two models already, which show whatever
/// became of comments and of the form of the numbers. The targets of a program have few decimals,
/// or fewer than its corrections are written with. Where the identified arm takes a command, the
/// target comes back: numbers that are long as they are written are short there, by the rounding of
/// the command. A target that is not corrected has it the other way round, so it never counts.
struct RoundWhereReached {
  int decimals = 0;  ///< that the numbers have where the arm takes them
  int numbers = 0;   ///< that have more as they are written, and differ in those
  int round = 0;     ///< of them
  int target = 0;    ///< row of one of them
  double written = 0, reached = 0;  ///< in the unit of the program, mm and deg of a table
};

/// Of a robot program; `targets` as compensate() gives them for it. Nothing if it may be chance.
std::optional<RoundWhereReached> find_round_where_reached(
    const RobotProgram& program, const std::vector<CorrectedTarget>& targets,
    const ProgramJoints& joints);

/// Of a table of the robot `controller`: of its poses and of its joint angles.
std::optional<RoundWhereReached> find_round_where_reached(
    const Robot& controller, const std::vector<CorrectedTarget>& targets);

}  // namespace armtrue
