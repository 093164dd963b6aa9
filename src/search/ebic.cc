#include "search/ebic.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace armtrue {
namespace {

// With more coefficients the residual has too few dimensions left for a test.
constexpr double kMaxShareOfFreedom = 0.75;
constexpr double kMinShareLeft = 1e-12;  // keeps the logarithm finite where nothing is left

}  // namespace

double ebic_fall(bool is_shrunken, double log_choices, int k, double gain, double before,
                 double freedom) {
  if (k == 0) return -std::numeric_limits<double>::infinity();
  const double left = std::max(kMinShareLeft, 1.0 - gain / before);
  const double fall = -freedom * std::log(left);
  const double count = k;
  if (!is_shrunken) return fall - count * std::log(freedom) - 2.0 * log_choices;
  if (count > kMaxShareOfFreedom * freedom) return -std::numeric_limits<double>::infinity();
  const double by_more_than_chance = fall * count / (-freedom * std::log(1.0 - count / freedom));
  const double charge =
      std::min(count * std::log(freedom),
               by_more_than_chance <= count ? by_more_than_chance
                                            : count * (1 + std::log(by_more_than_chance / count)));
  return by_more_than_chance - charge - 2.0 * log_choices;
}

}  // namespace armtrue
