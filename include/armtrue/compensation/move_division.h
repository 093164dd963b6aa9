#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/compensation/compensation.h"
#include "armtrue/programs/robot_program.h"
#include "armtrue/statistics/summary.h"

namespace armtrue {

/// A straight or circular move of a program whose points are corrected.
struct MoveBetweenPoints {
  size_t target = 0;  ///< its end
  /// The largest predicted distance of the TCP from the intended way, at the same time [m]: with
  /// corrected ends alone, and with the inserted points. Infinite if the controller's model cannot
  /// follow the way.
  double before = 0, after = 0;
  int inserted = 0;  ///< moves
  std::string why;   ///< `after` is above the tolerance; else empty
};

/// The moves of a program between their points.
struct BetweenPoints {
  double tolerance = 0;                  ///< of the predicted error [m]
  std::vector<MoveBetweenPoints> moves;  ///< whose way is known, in the order of the text
  int unknown = 0;                       ///< straight and circular moves whose way is not
  std::vector<CorrectedTarget> points;   ///< the inserted ones
};

/// Figures of BetweenPoints over all moves.
struct BetweenPointsSummary {
  int divided = 0, inserted = 0;              ///< moves
  std::optional<ErrorSummary> before, after;  ///< of the moves that can be followed [m]
};
BetweenPointsSummary summarize(const BetweenPoints& between);

/// The result of compensate(), with points inserted in the moves of the program.
struct DividedProgram {
  std::vector<CorrectedTarget> targets;       ///< of the program alone
  std::vector<ProgramPointBetween> inserted;  ///< in their order
  BetweenPoints between;
};

/// Corrects a program and divides its straight and circular moves until the predicted error between
/// two points is below the tolerance [m]: a line between two corrected points is straight in the
/// controller's model, not in the room. No two points of a move come nearer than 1 mm, no piece of
/// an arc is shorter than 5 deg, no point lies within twice the blend of an end or where the
/// rounding of the text decides in which direction a joint with backlash arrives, and none is
/// inserted where a program forbids it (ProgramTarget::obstacle); MoveBetweenPoints::why then says
/// so. `program` is that of `text`. Throws as compensate() does, and InputError if a move needs
/// more than 1000 points.
DividedProgram divide_moves(const Robot& identified, const Robot& controller,
                            const RobotProgram& text, const Program& program,
                            const CompensationOptions& options, double tolerance);

}  // namespace armtrue
