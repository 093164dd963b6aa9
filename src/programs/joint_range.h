#pragma once

#include "armtrue/programs/configuration.h"
#include "armtrue/programs/robot_program.h"

namespace armtrue {

/// Whether a joint is programmed in a range [rad], up to the rounding of a written pose, and
/// commanded outside of it.
inline bool leaves(double low, double high, int joint, const ProgramCommand& command) {
  constexpr double kWritten = 1e-4 * kDegree;  // the decimals of a pose
  const double before = command.programmed[joint], now = command.q[joint];
  return before >= low - kRangeSlack && before <= high + kRangeSlack &&
         (now < low - kWritten || now > high + kWritten);
}

}  // namespace armtrue
