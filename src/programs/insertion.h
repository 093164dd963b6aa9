#pragma once

#include <vector>

#include "armtrue/programs/robot_program.h"
#include "programs/text_edit.h"

namespace armtrue {

/// Decimals that a changed number has at least, in the order of ProgramPoint::numbers.
int decimals_kept(Dialect dialect, TargetKind kind, size_t component);

/// The edits that insert a move for each point, in the order in which the arm passes them, and that
/// replace the auxiliary points of divided arcs. The moves of the points have no obstacle.
std::vector<TextEdit> insertion_edits(const RobotProgram& program,
                                      const std::vector<ProgramPointBetween>& between);

/// Throws InputError if the controller would not load the program with so many moves more.
void refuse_what_does_not_load(const RobotProgram& program, size_t inserted);

}  // namespace armtrue
