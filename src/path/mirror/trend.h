#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "armtrue/path/mirror/mirror.h"

namespace armtrue {

/// A low pass without phase, and the share of white noise power that it lets through.
struct Smoother {
  std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)> smooth;
  double noise_share;
};

/// As the options have it, for samples taken at `rate`; both frequencies [Hz].
Smoother smoother(const MirrorOptions& options, double cutoff, double rate);

/// Throws std::invalid_argument for a cut-off with less than one period between the first of the
/// times and the last: the low pass would only draw a line through the record.
void check_lowest(double cutoff, const Eigen::VectorXd& time);

/// That of the options, checked, or the one with the least expected error [Hz].
double choose_cutoff(const PathDeviation& deviation, const MirrorOptions& options);

/// The pieces between breaks, each from its first sample to before the second number.
std::vector<std::pair<Eigen::Index, Eigen::Index>> pieces(const std::vector<Eigen::Index>& breaks,
                                                          Eigen::Index samples);

/// Smooths every piece by itself.
Eigen::Matrix3Xd smooth(const Eigen::Matrix3Xd& samples, const std::vector<Eigen::Index>& breaks,
                        const Smoother& smoother);

/// Mean square of what the trend of a deviation, straight between so many points or smooth, misses
/// of the true one, by Stein's unbiased estimate: what it leaves of the samples, less the noise,
/// plus twice the noise that it kept.
double expected_square(const PathDeviation& deviation, CorrectionPoints how, size_t points,
                       double noise_share);

}  // namespace armtrue
