#include "statistics/rounding.h"

#include <cmath>
#include <set>

namespace armtrue {

std::optional<int> last_digits(const std::vector<double>& values, double step) {
  constexpr double kExact = 1e-6;  // of a step
  std::set<double> digits;
  for (const double value : values) {
    const double steps = std::abs(value) / step;
    const double whole = std::round(steps);
    if (std::abs(steps - whole) > kExact) return std::nullopt;
    digits.insert(std::fmod(whole, 10));
  }
  return static_cast<int>(digits.size());
}

}  // namespace armtrue
