#pragma once

#include <vector>

#include "armtrue/tracing/loop.h"
#include "report/svg.h"

namespace armtrue {

/// What an effect adds to its parameter against its driver, with the 95 % band; null without a
/// curve. `number`: of the effect, for the name of the file.
Drawing effect_picture(const TracedEffect& traced, const std::vector<CurvePoint>& curve,
                       const Robot& robot, size_t number);

/// The change of the zero offset of a joint with its own angle in the applied arm, with its 95 %
/// band, and the part of the effects with a name.
Drawing joint_picture(const JointCurve& curve, const KinematicChain& chain);

}  // namespace armtrue
