#pragma once

#include <numbers>

namespace armtrue {

// Files hold mm, deg, mrad and ppm; everything inside is m, rad and 1. These are the only
// conversions.
inline constexpr double kMillimetre = 1e-3;
inline constexpr double kMilliradian = 1e-3;
inline constexpr double kDegree = std::numbers::pi / 180;
inline constexpr double kTurn = 2 * std::numbers::pi;
inline constexpr double kPartPerMillion = 1e-6;

}  // namespace armtrue
