#include "armtrue/statistics/intervals.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "armtrue/statistics/distributions.h"

namespace armtrue {
namespace {

constexpr double kCoverage = 0.95;

// Whether x, normal about mean >= 0 with unit variance, is among the 95 % of outcomes whose
// likelihood is largest relative to that of the best mean, max(0, x). With t = -2 log of this ratio,
// (x - mean)^2, or mean^2 - 2 x mean below zero, these have less than t: they lie between two ends.
bool is_plausible(double x, double mean) {
  const double t = x >= 0 ? (x - mean) * (x - mean) : mean * mean - 2 * x * mean;
  const double root = std::sqrt(t);
  double low = mean - root;
  if (low < 0)
    low = mean > 0 ? (mean * mean - t) / (2 * mean) : -std::numeric_limits<double>::infinity();
  return normal_below(root) - normal_below(low - mean) <= kCoverage;
}

}  // namespace

std::array<double, 2> not_negative_ci95(double value,
                                        const std::function<double(double)>& deviation) {
  const auto is_within = [&](double truth) {
    const double unit = deviation(truth);
    return unit > 0 ? is_plausible(value / unit, truth / unit) : truth == std::max(value, 0.0);
  };
  // Bisects between a truth in the interval and one outside it.
  const auto end_between = [&](double within, double outside) {
    constexpr int kHalvings = 60;
    for (int k = 0; k < kHalvings; ++k) {
      const double middle = 0.5 * (within + outside);
      (is_within(middle) ? within : outside) = middle;
    }
    return within;
  };
  const double best = std::max(value, 0.0);
  double beyond = best + 3 * deviation(best);
  if (beyond == best) return {best, best};
  while (is_within(beyond)) beyond += beyond - best;
  return {is_within(0) ? 0 : end_between(best, 0), end_between(best, beyond)};
}

std::array<double, 2> deviation_ci95(double deviation, double freedom) {
  const auto end = [&](double above) {
    return deviation * std::sqrt(freedom / chi_squared_quantile_above(above, freedom));
  };
  return {end((1 - kCoverage) / 2), end((1 + kCoverage) / 2)};
}

}  // namespace armtrue
