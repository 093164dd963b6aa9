#pragma once

#include <Eigen/Core>

namespace armtrue {

/// The deviation of a tool along one axis as a random process, of Ornstein and Uhlenbeck (1930),
/// that may jump where the motion changes, read with white noise:
///     x_i = a x_(i-1) + w_i,    a = exp(-(t_i - t_(i-1)) / correlation_time),
///     var w_i = (1 - a^2) deviation^2 + jump_share_i * jump^2,    var x_0 = deviation^2,
///     y_i = x_i + e_i,    var e_i = noise^2.
struct OrnsteinUhlenbeck {
  double deviation = 0;         ///< standard deviation of x [m]
  double correlation_time = 1;  ///< [s]
  double noise = 0;             ///< standard deviation of one reading [m]
  double jump = 0;              ///< standard deviation of a jump [m]
};

/// The samples of one axis, a row each: the data y in column 0, behind it the regressors.
struct AxisSamples {
  Eigen::VectorXd time;        ///< [s]
  Eigen::VectorXd jump_share;  ///< share of a jump's variance that falls just before each sample
  Eigen::MatrixXd columns;
  /// Coefficients of the regressors in the data, as far as they are known; empty for zero.
  Eigen::VectorXd explained;
};

/// The innovations of the Kalman filter of the process, each divided by its standard deviation s_i:
/// independent numbers of unit variance. Regressors are filtered like the data. A sample is a
/// blunder if its data, without what the regressors explain, lies more than 5 s_i off the
/// prediction: its row is zero, and it costs what one at 5 s_i costs.
struct Whitened {
  Eigen::MatrixXd columns;
  /// Sum of log s_i, half the log determinant of the covariance, plus 5^2 / 2 for each blunder.
  double log_determinant = 0;
  int blunders = 0;
};
Whitened whiten(const OrnsteinUhlenbeck& process, const AxisSamples& samples);

/// The process without jumps under which the data have the greatest restricted likelihood (REML,
/// Patterson and Thompson 1971): that of the data free of what the regressors explain. The
/// coefficients are those of least squares.
struct FittedProcess {
  OrnsteinUhlenbeck process;
  Eigen::VectorXd explained;
};
FittedProcess fit_ornstein_uhlenbeck(const AxisSamples& samples);

}  // namespace armtrue
