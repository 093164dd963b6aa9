#include "armtrue/statistics/summary.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "armtrue/statistics/distributions.h"

namespace armtrue {

double normal_length_exceeded(double probability) {
  return std::sqrt(chi_squared_quantile_above(probability, 3));
}

double median(std::vector<double> values) {
  if (values.empty()) throw std::invalid_argument("median: there are no values");
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double quantile(std::vector<double> values, double share) {
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

ErrorSummary summarize(std::vector<double> errors) {
  ErrorSummary summary;
  if (errors.empty()) return summary;
  double sum = 0, sum_of_squares = 0;
  for (double error : errors) {
    sum += error;
    sum_of_squares += error * error;
  }
  const double count = static_cast<double>(errors.size());
  summary.mean = sum / count;
  summary.rms = std::sqrt(sum_of_squares / count);
  // Linear between order statistics.
  const double place = 0.95 * (count - 1);
  const double below = std::floor(place);
  const auto at = errors.begin() + static_cast<size_t>(below);
  std::nth_element(errors.begin(), at, errors.end());
  const double above = at + 1 < errors.end() ? *std::min_element(at + 1, errors.end()) : *at;
  summary.p95 = *at + (place - below) * (above - *at);
  summary.max = *std::max_element(at, errors.end());
  return summary;
}

double robust_deviation(const std::vector<double>& deviations) {
  constexpr double kMedianToDeviation = 1.482602218505602;
  constexpr double kDeviationWithinThree = 0.9866;  // of a normal law cut at three deviations
  if (deviations.empty()) return 0;
  std::vector<double> sizes;
  for (double d : deviations) sizes.push_back(std::abs(d));
  double deviation = kMedianToDeviation * median(sizes);
  for (int round = 0; round < 10; ++round) {
    double sum = 0, count = 0;
    for (double size : sizes)
      if (size <= 3 * deviation) {
        sum += size * size;
        ++count;
      }
    if (count == 0) break;
    deviation = std::sqrt(sum / count) / kDeviationWithinThree;
  }
  return deviation;
}

}  // namespace armtrue
