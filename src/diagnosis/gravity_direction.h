#pragma once

#include <optional>

#include "diagnosis/plain_fit.h"

namespace armtrue {

/// Names a direction of gravity in R_0 that the sags of the joints fit far better than that of the
/// robot file, as of an arm on a wall. With T_j(g) the torque of gravity g on the revolute joint j,
///     theta_j += c_j T_j(g),  c_j >= 0
/// (of a robot file without masses a basis of the torque, of any sign) is fitted beside all
/// unknowns of a plain fit, for directions of g over the whole sphere. The best is named if it is
/// 15 deg or more from that of the file (without masses its opposite counts as the same), explains
/// half of the squared residual and most readings better, and lowers BIC by more than 20 against
/// its rivals, two numbers of the direction counted: the direction of the file, harmonics of one
/// joint's angle on a parameter of its link or the next one, as a bearing or an axis out of the
/// middle has them, and both.
std::optional<Suspicion> find_direction_of_gravity(const PlainFit& fit);

}  // namespace armtrue
