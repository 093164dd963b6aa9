#include "search/ebic.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace armtrue {
namespace {

constexpr double kMinShareLeft = 1e-12;  // keeps the logarithm finite where nothing is left

}  // namespace

double ebic_fall(bool is_shrunken, double log_choices, int k, double gain, double before,
                 double freedom) {
  if (k == 0) return -std::numeric_limits<double>::infinity();
  const double left = std::max(kMinShareLeft, 1.0 - gain / before);
  const double fall = -freedom * std::log(left);
  const double count = k;
  double charge = count * std::log(freedom);
  if (is_shrunken)
    charge = std::min(charge, fall <= count ? fall : count * (1 + std::log(fall / count)));
  return fall - charge - 2.0 * log_choices;
}

}  // namespace armtrue
