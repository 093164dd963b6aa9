#pragma once

#include <Eigen/Core>
#include <vector>

#include "armtrue/path/path.h"
#include "armtrue/programs/division.h"
#include "programs/krl_plan.h"

namespace armtrue {

/// The samples of the programmed path that lie on a move, with the displacement of each (a column
/// of `displacement` [m]). The first knot is the start of the move, the last one its end; an end
/// that lies off the path is not displaced. If only one end lies on the path, samples count from
/// there as far as the path follows the move. `start` and `end` of the plan must be known.
std::vector<Knot> knots_on_line(const KrlPlannedMove& plan, const Path& path,
                                const Eigen::Matrix3Xd& displacement);

/// The same for a circular move along `arc`.
std::vector<Knot> knots_on_arc(const KrlPlannedMove& plan, const Arc& arc, const Path& path,
                               const Eigen::Matrix3Xd& displacement);

}  // namespace armtrue
