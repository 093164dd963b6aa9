#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace armtrue {

/// One coefficient of a regression.
struct Estimate {
  double value = 0;
  double std = 0;
  std::array<double, 2> ci95{0, 0};
};

struct Regression {
  std::vector<Estimate> coefficients;  ///< in the order of the columns
  Eigen::VectorXd residual;
};

/// Least squares of `response` (n) on `columns` (n x p) over samples in the order of time, with
/// intervals that stay valid for a slowly varying (autocorrelated) residual.
///
/// The residual is projected on cosines of low frequency, weighted like the estimate and made
/// orthogonal to the columns. The mean square of the projections is the variance of the estimate;
/// Student's t with as many degrees of freedom as there are cosines gives the interval. The number
/// of cosines is a quarter of the effective number of samples, from 2 to 24, so that they stay at
/// frequencies where the spectrum is flat. The effective number comes from the integrated
/// correlation time of the residual. Source: Lazarus, Lewis, Stock and Watson 2018, "HAR inference"
/// (equal-weighted cosines), here with time measured by the weights of the estimate; Sokal 1997 for
/// the correlation time.
///
/// `noise` (p x p) is the covariance of the noise in one row of `columns`; its share of the normal
/// matrix, which would draw the coefficients towards zero, is subtracted (Fuller 1987, "Measurement
/// Error Models"). Several channels of one sample may stand as consecutive rows.
///
/// `shared` (n x m, m may be 0): each column is the change of the response by one error that all
/// samples have in common, such as that of a clock; these m errors are independent, with unit
/// variance. The residual does not show the part of them that looks like the columns. So they are
/// propagated into the intervals, with degrees of freedom after Welch and Satterthwaite (JCGM
/// 100:2008, G.4). Throws std::invalid_argument if sizes disagree, n <= p, or the columns are
/// dependent.
Regression regress_autocorrelated(const Eigen::MatrixXd& columns, const Eigen::VectorXd& response,
                                  const Eigen::MatrixXd& noise, const Eigen::MatrixXd& shared);

}  // namespace armtrue
