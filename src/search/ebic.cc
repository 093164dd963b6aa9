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

EbicFall::EbicFall(bool is_shrunken, double log_choices, int k, double freedom)
    : is_shrunken_(is_shrunken),
      is_possible_(k != 0 && (!is_shrunken || k <= kMaxShareOfFreedom * freedom)),
      log_choices_(log_choices),
      count_(k),
      freedom_(freedom),
      full_charge_(count_ * std::log(freedom)),
      by_chance_(-freedom * std::log(1.0 - count_ / freedom)) {}

double EbicFall::operator()(double gain, double before) const {
  if (!is_possible_) return -std::numeric_limits<double>::infinity();
  const double left = std::max(kMinShareLeft, 1.0 - gain / before);
  const double fall = -freedom_ * std::log(left);
  if (!is_shrunken_) return fall - full_charge_ - 2.0 * log_choices_;
  const double by_more_than_chance = fall * count_ / by_chance_;
  const double charge =
      std::min(full_charge_, by_more_than_chance <= count_
                                 ? by_more_than_chance
                                 : count_ * (1 + std::log(by_more_than_chance / count_)));
  return by_more_than_chance - charge - 2.0 * log_choices_;
}

}  // namespace armtrue
