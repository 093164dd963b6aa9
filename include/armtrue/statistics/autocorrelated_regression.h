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
/// intervals that stay honest when the residual wanders slowly.
///
/// The residual is projected on cosines of low frequency, weighted like the estimate and made
/// orthogonal to the columns: the mean square of the projections is the variance of the estimate,
/// Student's t with as many degrees of freedom as there are cosines gives the interval. Their
/// number is a quarter of the effective number of samples (which the residual's own integrated
/// correlation time gives), from 2 to 24, so that they stay where the spectrum is flat.
/// Source: Lazarus, Lewis, Stock and Watson 2018, "HAR inference" (equal-weighted cosines), here in
/// the time of the estimate's own weights; Sokal 1997 for the correlation time.
///
/// `noise` (p x p) is the covariance of the noise in one row of `columns`; its share of the normal
/// matrix, which draws the coefficients towards zero, is taken off (Fuller 1987, "Measurement Error
/// Models"). Several channels of one sample may stand as consecutive rows.
///
/// `shared` (n x m, m may be 0) is what each of m independent errors of unit variance, which
/// all samples have in common, adds to the response: a clock's, for one. The residual cannot show
/// what of them looks like the columns, so they are propagated into the intervals, their degrees of
/// freedom after Welch and Satterthwaite (JCGM 100:2008, G.4).
/// Throws std::invalid_argument if sizes disagree, n <= p, or the columns are dependent.
Regression regress_autocorrelated(const Eigen::MatrixXd& columns, const Eigen::VectorXd& response,
                                  const Eigen::MatrixXd& noise, const Eigen::MatrixXd& shared);

}  // namespace armtrue
