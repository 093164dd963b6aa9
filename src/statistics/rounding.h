#pragma once

#include <optional>
#include <vector>

namespace armtrue {

/// Number of different last digits of the values in units of `step`; nothing if one of them is no
/// multiple of it. Values that were rounded so show nearly all ten digits if they vary.
std::optional<int> last_digits(const std::vector<double>& values, double step);

/// Fewer may be chance, or numbers that were chosen.
inline constexpr int kFewestLastDigits = 8;

}  // namespace armtrue
