#pragma once

#include <limits>
#include <vector>

#include "armtrue/path/path.h"
#include "armtrue/programs/krl.h"
#include "programs/krl_pose.h"
#include "programs/krl_syntax.h"

namespace armtrue {

/// A point of a program lies on the path if its distance is at most this [m], which allows for
/// rounding between the program and the path.
inline constexpr double kKrlMatchTolerance = 1e-4;

/// A move of the program, before any correction.
struct KrlPlannedMove {
  bool known = false;  ///< the positions of all its points
  KrlValues start, auxiliary, end;
  /// Where the points lie on the path, in samples (places_in_order()); NaN: off the path.
  double start_place = std::numeric_limits<double>::quiet_NaN();
  double auxiliary_place = start_place, end_place = start_place;
  /// The part of the path that the move may cover, in samples: from the last point found before
  /// its end to the next point found from its end on.
  double from = 0, to = 0;
};

/// One for each move of `syntax`. `path` is the programmed one, in the $BASE of the program.
/// Throws InputError if no position of the program is known, or none lies on the path.
std::vector<KrlPlannedMove> plan_krl_moves(const KrlProgram& program, const KrlSyntax& syntax,
                                           const Path& path);

}  // namespace armtrue
