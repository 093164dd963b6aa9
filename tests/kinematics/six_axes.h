#pragma once

// The usual arm of the tests: six revolute joints, then one fixed link.

#include "armtrue/kinematics/parameters.h"

namespace armtrue {

inline constexpr int kJoints = 6;
inline constexpr int kLinks = kJoints + 1;
inline constexpr ParameterLayout kSixAxes(kLinks);
inline constexpr int kFirstToolParameter = kSixAxes.tool;
inline constexpr int kGeometricParameters = kSixAxes.geometric;
inline constexpr int kInstrumentScale = kSixAxes.instrument_scale;
inline constexpr int kTargetParameters = kSixAxes.targets;

}  // namespace armtrue
