#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/path/path.h"
#include "armtrue/programs/displacement.h"
#include "armtrue/programs/program_text.h"

namespace armtrue {

using KrlFile = ProgramText;

/// A program of a KUKA controller: the `.src` and, if there is one, the `.dat` with its points.
struct KrlProgram {
  KrlFile src;
  std::optional<KrlFile> dat;
};

using KrlCorrectionOptions = DisplacementOptions;

struct CorrectedKrl {
  std::string src;
  std::optional<std::string> dat;  ///< if the program has one, changed or not
  int corrected = 0;               ///< moves whose end lies on the path and is displaced
  int inserted = 0;                ///< new moves
  int left_alone = 0;              ///< all other moves
  std::vector<std::string> warnings;
};

/// Displaces the points of the program as the correction displaces the path: `programmed`, in the
/// $BASE of the program, becomes `corrected` (3 x samples, [m]).
///
/// Which points: the ends and auxiliary points of PTP, LIN, CIRC, their spline forms and SPL, given
/// as a frame {X .., Y .., ..} or as a name to which the .src or the .dat gives a frame. They are
/// searched on the path in the order of the text (places_in_order()). These moves are left alone,
/// each with a warning: those that end off the path, go to axis angles or to an expression, use a
/// name that is declared elsewhere or gets several values, and relative moves, which start from the
/// corrected point before them.
///
/// Where the correction bends the path between two points, moves LIN .. C_DIS (SLIN .. C_SPL) are
/// inserted; their orientation and external axes lie between those of the two points. A CIRC
/// becomes several, or LIN where a piece is straight; the auxiliary point of each lies half-way.
/// Nothing is inserted in a spline block or behind a TRIGGER.
///
/// Only X, Y, Z change. They are rounded to 0.0001 mm, or finer where more decimals were written;
/// no zeros are added at the end. A component that a frame omits has the value of the move before;
/// it is added if that value is now different. A named point is changed in its declaration; if its
/// moves need different corrections, or others use it, frames replace the name in the moves. Every
/// other byte is kept; without displacement all bytes are.
///
/// Throws InputError if no point lies on the path.
CorrectedKrl correct_krl(const KrlProgram& program, const Path& programmed,
                         const Eigen::Matrix3Xd& corrected,
                         const KrlCorrectionOptions& options = {});

}  // namespace armtrue
