#pragma once

#include <Eigen/Core>

namespace armtrue {

/// Cubic smoothing spline with natural ends (Reinsch) of samples taken at `rate` [Hz]: the
/// same zero-phase response as two passes of a Butterworth filter of order 2 with its -3 dB at
/// `cutoff` [Hz], but with no assumption of what lies beyond the ends. Rows are channels; returns
/// the spline's values at the samples.
Eigen::MatrixXd smoothing_spline(const Eigen::MatrixXd& samples, double cutoff, double rate);

/// Share of white noise power that it lets through.
double smoothing_spline_noise_share(double cutoff, double rate);

}  // namespace armtrue
