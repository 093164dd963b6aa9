#pragma once

#include <Eigen/Core>

namespace armtrue {

/// What a tool deviates by along one axis, as a random process: Ornstein and Uhlenbeck's, which may
/// jump where the motion changes, read with white noise.
struct DeviationLaw {
  double deviation = 0;         ///< standard deviation [m]
  double correlation_time = 1;  ///< [s]
  double noise = 0;             ///< standard deviation of one reading [m]
  double jump = 0;              ///< standard deviation of a jump [m]
};

/// The samples of one axis by row: the data first, then its regressors, which are filtered alike.
struct AxisSamples {
  Eigen::VectorXd time;   ///< [s]
  Eigen::VectorXd share;  ///< of a jump's variance that falls between a sample and the one before
  Eigen::MatrixXd columns;
};

/// The columns of independent numbers of unit variance that stand for samples of the law (the
/// innovations of its Kalman filter). A sample whose data lies more than five deviations off its
/// prediction is a blunder; its row becomes zero and it costs as if it lay just there.
struct Whitened {
  Eigen::MatrixXd columns;
  double log_determinant = 0;  ///< half that of the covariance, and what the blunders cost
  int blunders = 0;
};
Whitened whiten(const DeviationLaw& law, const AxisSamples& samples);

/// Minus the logarithm of the restricted likelihood: of the data, free of what regressors explain.
/// If asked for, `best_scale` becomes the factor on the law's sizes for which the data are
/// likeliest, and the cost is that at this factor.
double cost(const DeviationLaw& law, const AxisSamples& samples, double* best_scale = nullptr);

/// The law without jumps under which the data are likeliest.
DeviationLaw fit_law(const AxisSamples& samples);

}  // namespace armtrue
