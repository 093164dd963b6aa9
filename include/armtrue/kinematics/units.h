#pragma once

#include <numbers>

namespace armtrue {

// Files hold mm, deg and mrad; everything inside is m and rad. These are the only conversions.
inline constexpr double kMillimetre = 1e-3;
inline constexpr double kMilliradian = 1e-3;
inline constexpr double kDegree = std::numbers::pi / 180;

}  // namespace armtrue
