#pragma once

#include <vector>

#include "armtrue/tracing/loop.h"
#include "report/svg.h"

namespace armtrue {

/// What an effect makes of its parameter over its driver, with the 95 % band; null without a curve.
/// `number`: of the effect, for the name of the file.
Drawing effect_picture(const TracedEffect& traced, const std::vector<CurvePoint>& curve,
                       const Robot& robot, size_t number);

/// The curve of a joint in the arm that is applied, with its band, and the part that has a name.
Drawing joint_picture(const JointCurve& curve, const KinematicChain& chain);

}  // namespace armtrue
