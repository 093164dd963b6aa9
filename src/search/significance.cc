#include "search/significance.h"

#include <algorithm>
#include <cmath>

#include "armtrue/calibration/evaluation.h"

namespace armtrue {
namespace {

constexpr double kClearLackOfFit = 1e-3;  // p

}  // namespace

double significance_level(const CalibrationResult& fit, const Campaign& campaign, double with_lack,
                          double without_lack) {
  const double lack_of_fit = assess(fit, campaign).lack_of_fit_in_position.value_or(1.0);
  const double missing = std::clamp(std::log(lack_of_fit) / std::log(kClearLackOfFit), 0.0, 1.0);
  return without_lack * std::pow(with_lack / without_lack, missing);
}

}  // namespace armtrue
