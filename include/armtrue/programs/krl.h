#pragma once

#include <optional>
#include <string>
#include <vector>

#include "armtrue/path/path.h"

namespace armtrue {

/// A text of the controller, byte by byte; its encoding and line ends do not matter.
struct KrlFile {
  std::string name;  ///< for messages
  std::string text;
};

/// A program of a KUKA controller: the `.src` and, where there is one, the `.dat` with its points.
struct KrlProgram {
  KrlFile src;
  std::optional<KrlFile> dat;
};

struct KrlCorrectionOptions {
  /// No inserted point lies nearer to the next one [m]: a controller reads a move ahead for each
  /// and blends over half of it. At 27 mm/s three cycles of 12 ms; a step of the correction becomes
  /// as long.
  double spacing = 1e-3;
  double tolerance = 5e-6;  ///< how far the moves may stray from the corrected path before a point
                            ///< is inserted [m]; a tenth of what a machining robot shall reach
};

struct CorrectedKrl {
  std::string src;
  std::optional<std::string> dat;  ///< where the program has one, changed or not
  int corrected = 0;               ///< moves whose end lies on the path
  int inserted = 0;                ///< new moves
  int left_alone = 0;              ///< all other moves
  std::vector<std::string> warnings;
};

/// The program with its points displaced as the path `programmed` (in the $BASE of the program) is
/// displaced to `corrected` (3 x samples, [m]).
///
/// Points of PTP, LIN, CIRC, their spline forms and SPL count: a frame {X .., Y .., ..}, or a name
/// that the .src or the .dat gives a frame. In the order of the text they are looked for on the
/// path (see places_in_order); what is not on it is left alone, as are axis angles, names declared
/// elsewhere or used for more than moves, and expressions, and relative moves, which start from the
/// corrected point before them. Warnings name all of them.
///
/// Where the path between two points is bent by the correction, LIN .. C_DIS (SLIN .. C_SPL) are
/// inserted with the orientation and external axes between; a CIRC becomes several, or
/// LIN where a piece is straight; their auxiliary points lie half-way on each. Nothing is inserted
/// in a spline block or behind a TRIGGER.
///
/// Only X, Y, Z change, rounded to 0.0001 mm (finer where more decimals were written), without
/// zeros at the end that were not there; a component that was left out, and so came from the move
/// before, is added where that no longer holds. A named point is changed in its declaration, or, if
/// its moves need different corrections or others use it, written into the moves. Every other byte
/// stands; without displacement all do.
///
/// Throws InputError if no point lies on the path.
CorrectedKrl correct_krl(const KrlProgram& program, const Path& programmed,
                         const Eigen::Matrix3Xd& corrected,
                         const KrlCorrectionOptions& options = {});

}  // namespace armtrue
