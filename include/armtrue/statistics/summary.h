#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace armtrue {

/// Mean, root mean square, 95th percentile and maximum of a sample of errors; zero if it is empty.
struct ErrorSummary {
  double mean = 0, rms = 0, p95 = 0, max = 0;
};

ErrorSummary summarize(std::vector<double> errors);

/// Returns the length x with P(|v| > x) = probability, v of three independent N(0, 1) components.
double normal_length_exceeded(double probability);

/// Mean of value(item), numbers or vectors, over one item or more. `value`: a function, or a member
/// of the items.
template <typename Items, typename Value>
auto mean_of(const Items& items, const Value& value) {
  auto sum = std::invoke(value, items.front());
  for (size_t k = 1; k < items.size(); ++k) sum += std::invoke(value, items[k]);
  return sum /= static_cast<double>(items.size());
}

/// Throws std::invalid_argument if there are no values.
double median(std::vector<double> values);

/// The value with index floor(share (n - 1)) of the n sorted values, n > 0; `share` from 0 to 1.
double quantile(std::vector<double> values, double share);

/// Robust standard deviation about zero: from the median of |x|, then ten times from the root mean
/// square of the values within three standard deviations; both are made consistent for a normal
/// law. 0 if there are no values.
double robust_deviation(const std::vector<double>& deviations);

/// Efficiency of robust_deviation(): of n normal values it is as uncertain as the root mean square
/// of this share of them. With psi(x) = x^2 - c^2 where |x| < 3, c^2 the mean of x^2 there, it is
/// (E psi')^2 / (2 E psi^2), psi' by the deviation (Huber, "Robust statistics", 1981, 5.2).
inline constexpr double kEfficiencyOfRobustDeviation = 0.864;

}  // namespace armtrue
