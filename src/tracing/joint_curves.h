#pragma once

#include <vector>

#include "armtrue/tracing/effect_curve.h"
#include "tracing/random_effects.h"

namespace armtrue {

/// The curve of each joint of an applied arm: see JointCurve. The points stand at equal steps over
/// the angles of `campaign`, fine enough for the shapes; means over the campaign are taken off.
/// With the coefficients of named effects and the random numbers in one vector of covariance C, and
/// w(x) the derivatives of the curve by them, the variance at x is w^T C w. Joints without effects
/// are left out. `arm`: applied_arm() with `random`.
std::vector<JointCurve> joint_curves(const CalibrationResult& arm, const RandomEffects& random,
                                     const Campaign& campaign);

}  // namespace armtrue
