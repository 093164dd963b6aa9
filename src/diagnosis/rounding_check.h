#pragma once

#include <optional>
#include <string>

#include "diagnosis/plain_fit.h"

namespace armtrue {

/// Names joint angles that were rounded, as those read from a display are. With the step s of the
/// angles and the whitened columns J_j of the joints, rounding leaves the expected square
///     e = sum_j |J_j|^2 s^2 / 12.
/// It counts if e is between a third and three times |r|^2, r the whitened residual: a smaller e
/// does not matter, and exact angles on a grid of s, as commanded, leave less than e. The step is a
/// tenth or a hundredth of a degree; whole and half degrees are planned angles.
std::optional<std::string> find_rounded_angles(const PlainFit& fit);

/// Names points or orientations that were rounded so that the rounding is a third or more of the
/// variance that the fit leaves, s^2 / 12 for the step s: 1, 0.1 or 0.01 mm or deg, in all axes.
std::optional<std::string> find_rounded_readings(const PlainFit& fit);

}  // namespace armtrue
