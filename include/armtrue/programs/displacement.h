#pragma once

#include <Eigen/Core>
#include <optional>

#include "armtrue/path/path.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

struct DisplacementOptions {
  /// Least distance of an inserted point from the next point [m]. The controller reads ahead and
  /// blends over half a move; 1 mm is three cycles of 12 ms at 27 mm/s. A step of the correction is
  /// spread over this length.
  double spacing = 1e-3;
  /// A point is inserted where a move would be farther from the corrected path [m]: a tenth of
  /// kFormGoal.
  double tolerance = 5e-6;
  std::optional<Corrector> by;  ///< as of rewrite()
};

/// A point of a program lies on the path if it is no farther from it [m]: rounding moves it by
/// less.
inline constexpr double kPathMatchTolerance = 1e-4;

/// The result of displace_program().
struct DisplacedProgram {
  RewrittenProgram text;
  int corrected = 0;   ///< targets that lie on the path, auxiliary points of arcs among them
  int left_alone = 0;  ///< moves that do not end on the path, or cannot be followed
  std::vector<std::string> warnings;
};

/// Whether more points of the program lie on the corrected path alone than on the programmed path
/// alone: then the program is corrected already.
bool lies_on_corrected(const RobotProgram& program, const Eigen::Matrix3Xd& programmed,
                       const Eigen::Matrix3Xd& corrected);

/// Displaces the Cartesian targets of a program as the correction displaces the path: `programmed`
/// in the frame of the program becomes `corrected` (3 x samples, [m]). Targets are found on the
/// path in the order of the text (places_in_order()). Orientations and external axes stay; a target
/// off the path keeps its text; a relative move ends where it did.
///
/// Where the correction bends the path along a straight or circular move, points are inserted, as
/// rewrite() does; their orientation and external axes lie between those of the ends. Where the
/// path covers a straight move in part, the correction fades out at the end off the path. No piece
/// of an arc is shorter than kShortestArc; of KUKA, pieces that are straight become lines instead.
/// Throws InputError if no target lies on the path.
DisplacedProgram displace_program(const RobotProgram& program, const Path& programmed,
                                  const Eigen::Matrix3Xd& corrected,
                                  const DisplacementOptions& options = {});

}  // namespace armtrue
