#pragma once

#include <optional>
#include <vector>

#include "armtrue/programs/robot_program.h"
#include "programs/text_edit.h"

namespace armtrue {

/// Decimals that a changed number has at least, in the order of ProgramPoint::numbers.
int decimals_kept(Dialect dialect, TargetKind kind, size_t component);

/// Check digits of a changed number.
struct NumberCheck {
  int decimals = 0;  ///< that it has with two of them at the end; 0: there is no room
  int rounded = 0;   ///< decimals to which it may be rounded and is checked still; 0: none
};
NumberCheck number_check(Dialect dialect, TargetKind kind, size_t component);

/// The most by which check digits move a number, in its unit.
double moved_by_check(Dialect dialect, TargetKind kind, size_t component);

/// A point that a move gets for itself in place of a declared one.
struct OwnPoint {
  size_t target = 0;
  std::vector<TextEdit> changes;  ///< of the declaration, in its text: what the own point states
  std::string text;               ///< the own point; empty: it is the declaration with the changes
};

/// The edits that insert a move for each point `between`, in the order in which the arm passes
/// them, that replace the auxiliary points of divided arcs, and that write own points into their
/// moves. `changes`: of the point of the target of each point between, to make this one of it. The
/// moves of the points have no obstacle.
std::vector<TextEdit> insertion_edits(const RobotProgram& program,
                                      const std::vector<ProgramPointBetween>& between,
                                      const std::vector<std::vector<TextEdit>>& changes,
                                      const std::vector<OwnPoint>& own);

/// Throws InputError if the controller would not load the program with so many moves more.
void refuse_what_does_not_load(const RobotProgram& program, size_t inserted);

}  // namespace armtrue
