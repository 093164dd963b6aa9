#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/compensation/corrected_before.h"
#include "armtrue/compensation/move_division.h"
#include "armtrue/compensation/program_joints.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

// What correcting a program finds, as sentences. `source`: the name of the program or table.

/// The joints of a program among those of the controller's model. Throws InputError if that is no
/// arm of six axes, or has external axes that programs of this maker do not state. `name`: of the
/// model's file.
ProgramJoints joints_of_program(const RobotProgram& program, const Robot& controller,
                                const std::string& name);

/// Whether the arm that a program states is that of the controller's model: the first one that is
/// not, as a doubt; empty if there is none. Throws InputError if it is an arm of other lengths.
/// `name`: of the model's file.
std::string doubt_of_stated_arm(const RobotProgram& program, const Robot& controller,
                                const ProgramJoints& joints, const std::string& name);

/// Whether files of the controller name another arm than its model does, as a doubt; empty if not,
/// or if a name tells nothing. `name`: of the model's file.
std::string doubt_of_arm_name(const RobotProgram& program, const Robot& controller,
                              const std::string& name);

/// Throws InputError if a target names a tool, and --tool-is-measured states another.
void refuse_two_tools(const RobotProgram& program, bool tool_is_measured);

/// Calls leave_alone() for the moves whose place is not known: the program only names their frame
/// or tool, does not state where an external axis stands, or lacks the angle of an axis. If no
/// Cartesian move would be left, leaves nothing alone: program_targets() names all that is missing.
void leave_what_has_no_place(RobotProgram& program, const ProgramJoints& joints);

/// The first of the postures [rad], of the arm alone, with all joints of the model; nothing if they
/// are on several branches, or none.
std::optional<JointVector> common_posture(const Robot& controller,
                                          const CompensationOptions& options,
                                          const ProgramJoints& joints,
                                          const std::vector<JointVector>& postures);

/// Calls leave_alone() for the moves that the controller's model does not reach. If it reaches
/// none as a whole, frames or arm are wrong: leaves nothing alone and returns false.
bool leave_what_is_out_of_reach(const UnreachableTarget& error, RobotProgram& program);

/// A sentence for each note that targets have: how many targets, and which.
std::vector<std::string> sentences_of_notes(const std::vector<CorrectedTarget>& targets,
                                            const Campaign& visits, const std::string& source);

/// Moves whose error between points stays too large, those of one cause together, and those of
/// which nothing is known.
std::vector<std::string> sentences_of_moves(const BetweenPoints& between, const Campaign& visits,
                                            const std::string& source);

/// An error: the targets are commands already, as their numbers show without a mark. `arm`: the
/// name of the identified arm's file.
std::string why_corrected_before(const RoundWhereReached& found, const Campaign& visits,
                                 const std::string& source, const std::string& arm);

}  // namespace armtrue
