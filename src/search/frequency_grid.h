#pragma once

#include <cmath>

namespace armtrue {

/// Of a periodogram, within its resolution: at the worst place between two steps 3 % of the
/// amplitude are lost.
inline constexpr int kFrequencySteps = 4;

/// No campaign shows more digits of a frequency.
inline double readable(double cycles_per_turn) { return std::round(1e4 * cycles_per_turn) / 1e4; }

}  // namespace armtrue
