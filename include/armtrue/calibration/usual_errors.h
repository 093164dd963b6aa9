#pragma once

#include <numbers>

namespace armtrue {

/// Usual error of a length of an arm against its data sheet, by tolerances of castings and of the
/// assembly of gears [m]. Two thirds of all arms are within a factor of two: ln of their errors has
/// the standard deviation kSpreadOfArms.
inline constexpr double kUsualErrorOfLength = 3e-4, kSpreadOfArms = std::numbers::ln2;

}  // namespace armtrue
