#pragma once

#include <optional>
#include <string>

#include "diagnosis/plain_fit.h"

namespace armtrue {

/// Names joint angles that were read while the arm still moved. With s the sign of arrival of the
/// joints, or their last motion,
///     theta_j += c_j s_j
/// beside all unknowns of the fit and the sag of the joints under gravity. Backlash differs from
/// gear to gear, and its arm stays behind (c < 0). One of two conditions, besides a fall of BIC by
/// more than 20 with one c for all joints:
/// - one c explains as much as the c_j (BIC is not higher), of either sign; the readings show of
///   more than half of the joints, three at least, that c_j is c within a quarter, and of none that
///   it is not;
/// - more than half of the joints, three at least, clearly go on the way that they came (c_j above
///   zero by three standard deviations), none clearly stays behind, and one c explains half of what
///   the c_j explain.
/// `all`: the readings that were fitted and those between them. Nothing for touches, a positioner
/// or a prismatic joint.
std::optional<std::string> find_early_angles(const PlainFit& fit, const Campaign& all);

}  // namespace armtrue
