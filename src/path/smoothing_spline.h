#pragma once

#include <Eigen/Core>

namespace armtrue {

/// Cubic smoothing spline with natural ends (Reinsch 1967) of samples taken at `rate` [Hz]. At low
/// frequencies it has the zero-phase response of a Butterworth filter of order 2 run both ways,
/// with -3 dB at `cutoff` [Hz]; it assumes nothing beyond the ends. Rows are channels. Returns the
/// values of the spline at the samples.
Eigen::MatrixXd smoothing_spline(const Eigen::MatrixXd& samples, double cutoff, double rate);

/// Share of white noise power that the spline lets through.
double smoothing_spline_noise_share(double cutoff, double rate);

}  // namespace armtrue
