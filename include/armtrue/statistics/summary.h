#pragma once

#include <Eigen/Core>
#include <vector>

namespace armtrue {

/// Mean, root mean square, 95th percentile and maximum of a sample of errors.
struct ErrorSummary {
  double mean = 0, rms = 0, p95 = 0, max = 0;
};

ErrorSummary summarize(std::vector<double> errors);

/// The length that vectors of three normal components of unit variance exceed with a probability.
double normal_length_exceeded(double probability);

double median(std::vector<double> values);

/// Robust standard deviation about zero: the median of |x| to start, then the root mean square of
/// what lies within three of it, both made consistent for a normal law.
double robust_deviation(const std::vector<double>& deviations);

}  // namespace armtrue
