#pragma once

#include <optional>
#include <string>

#include "diagnosis/plain_fit.h"

namespace armtrue {

/// Names joint angles that were read while the arm still moved. With s the sign of arrival of the
/// joints, their last motion, or this motion over that of the joint that moves most (joints that
/// arrive together, read at one moment before),
///     theta_j += c_j s_j
/// beside all unknowns of the fit and the sag of the joints under gravity. Backlash differs from
/// gear to gear. Named, if one c for all joints lowers BIC by more than 20, explains as much as the
/// c_j (BIC is not higher) and as a backlash of each joint, and the readings show of more than half
/// of the joints, three at least, that c_j is c within a quarter, and of none that it is not.
/// `all`: the readings that were fitted and those between them. Nothing for touches, a positioner
/// or a prismatic joint.
std::optional<std::string> find_early_angles(const PlainFit& fit, const Campaign& all);

}  // namespace armtrue
