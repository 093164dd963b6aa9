#pragma once

#include <cmath>

namespace armtrue {

/// Steps of a periodogram per resolution: midway between two steps 3 % of the amplitude are lost.
inline constexpr int kFrequencySteps = 4;

/// The frequency, rounded to four decimals: no campaign shows more.
inline double readable(double cycles_per_turn) { return std::round(1e4 * cycles_per_turn) / 1e4; }

}  // namespace armtrue
