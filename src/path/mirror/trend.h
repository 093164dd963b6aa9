#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "armtrue/path/mirror/mirror_options.h"
#include "armtrue/path/mirror/path_deviation.h"

namespace armtrue {

/// A zero-phase low pass, and the share of white noise power that it lets through.
struct Smoother {
  std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)> smooth;
  double noise_share;
};

/// The smoother that the options ask for, for samples taken at `rate`; both frequencies [Hz].
Smoother smoother(const MirrorOptions& options, double cutoff, double rate);

/// Throws std::invalid_argument if a period of the cut-off is longer than the time from the first
/// to the last of `time`: the low pass would leave a straight line.
void check_lowest(double cutoff, const Eigen::VectorXd& time);

/// The cut-off of the options, checked, or the one with the least expected_square() [Hz].
double choose_cutoff(const PathDeviation& deviation, const MirrorOptions& options);

/// The pieces between breaks, as [first, end).
std::vector<std::pair<Eigen::Index, Eigen::Index>> pieces(const std::vector<Eigen::Index>& breaks,
                                                          Eigen::Index samples);

/// Smooths every piece between breaks by itself.
Eigen::Matrix3Xd smooth(const Eigen::Matrix3Xd& samples, const std::vector<Eigen::Index>& breaks,
                        const Smoother& smoother);

/// Mean square error of the trend of a deviation, by Stein's unbiased estimate (1981):
///     mean |normal - trend|^2 - 2 noise^2 + 2 * 2 noise^2 * kept,
/// at least 2 noise^2 * kept; the 2 are the components across the path. `kept` is the share of the
/// noise in the trend: that of a polygon with `points` vertices, or that of the smoother with
/// `noise_share` and one free constant for each piece.
double expected_square(const PathDeviation& deviation, CorrectionPoints how, size_t points,
                       double noise_share);

}  // namespace armtrue
