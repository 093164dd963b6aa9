#pragma once

#include <string>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// A straight or circular move of a program whose points are corrected.
struct MoveBetweenPoints {
  size_t target = 0;  ///< the end of the move
  /// Largest predicted distance of the TCP from its intended position at the same time [m]: with
  /// corrected ends alone, and with the inserted points. Infinite if the controller's model cannot
  /// follow the move.
  double before = 0, after = 0;
  int inserted = 0;  ///< points
  std::string why;   ///< reason if `after` is above the tolerance; else empty
};

/// The result of compensate() for a program, and the points inserted in its straight moves.
struct StraightenedProgram {
  std::vector<CorrectedTarget> targets;       ///< of the program alone
  std::vector<ProgramPointBetween> inserted;  ///< in their order
  std::vector<MoveBetweenPoints> moves;  ///< moves whose path is known, in the order of the text
  int unknown = 0;  ///< number of straight and circular moves whose path is not known
};

/// Corrects a program and inserts points in its straight moves until the predicted error between
/// two points is below the tolerance [m]: a line between two corrected points is straight in the
/// controller's model, but not in reality. Points of a move are at least 1 mm apart, none lies
/// within the blend of an end, and none is inserted where the program forbids it
/// (ProgramTarget::obstacle); MoveBetweenPoints::why then gives the reason. `program` is that of
/// `text`. Throws as compensate() does, and InputError if a move needs more than 1000 points.
StraightenedProgram straighten_moves(const Robot& identified, const Robot& controller,
                                     const RobotProgram& text, const Program& program,
                                     const CompensationOptions& options, double tolerance);

}  // namespace armtrue
