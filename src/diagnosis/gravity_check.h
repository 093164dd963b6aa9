#pragma once

#include <optional>
#include <string>

#include "diagnosis/plain_fit.h"

namespace armtrue {

/// Names a `gravity` that points the wrong way, where the robot file has masses. With T_j the
/// torque of gravity on a revolute joint,
///     theta_j += c T_j
/// beside all unknowns of the fit. No joint gives way against its torque: the one that explains the
/// residual best has c < 0, explains a third of its square, and lowers BIC by more than 20.
std::optional<std::string> find_reversed_gravity(const PlainFit& fit);

}  // namespace armtrue
