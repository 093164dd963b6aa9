#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <vector>

#include "armtrue/campaign/campaign.h"
#include "armtrue/observation/observation.h"

namespace armtrue {

inline constexpr double kMinSigma = 1e-9;  // m, rad: noise-free simulations must not divide by zero

/// Student's t as the law of the readings: with few degrees of freedom a blunder hardly counts,
/// with infinitely many it is least squares. Its weights fall smoothly: no reading is rejected, and
/// a remaining systematic error of the model only lowers the weight of the worst rows.
///
/// With s the squared norm of the whitened residual of a row, d its dimension, v the variance of
/// the row in units of the campaign's, and nu the degrees of freedom:
///     loss(s)   = v (nu + d) log(1 + s / (v nu))
///     weight(s) = loss'(s) = (nu + d) / (nu + s / v)
/// loss(s) is twice the negative log-likelihood of the row, times v and up to a constant. Gaussian:
/// loss(s) = s, weight(s) = 1.
/// Source: Lange, Little, Taylor, "Robust statistical modeling using the t distribution", 1989.
///
/// A blunder is an error of one reading; an error of the model is in every reading of a pose. So if
/// all readings of a pose are off, each is compared with the others: v is then above 1 (see
/// pose_variances). The pose as a whole has a bounded influence, however often it was read: with
/// u = v, or a bound b where v is larger,
///     loss(s) = u (nu + d) log(1 + s / (v nu)),   weight(s) = u / v (nu + d) / (nu + s / v).
struct ReadingLaw {
  double degrees_of_freedom = 0;                                  ///< nu; 0: Gaussian
  std::vector<double> variance{};                                 ///< v of each row; empty: 1
  double most_counted = std::numeric_limits<double>::infinity();  ///< b

  bool operator==(const ReadingLaw&) const = default;
  double variance_of(int row) const { return variance.empty() ? 1.0 : variance[row]; }
  double counted_variance(double row_variance) const {
    return std::min(row_variance, most_counted);
  }  ///< u
  double weight(double squared_norm, int dimension, double row_variance = 1.0) const;
  double loss(double squared_norm, int dimension, double row_variance = 1.0) const;
};

/// Variances for ReadingLaw from the squared norms s of the whitened residuals: for a row, the
/// geometric mean of s / dimension over the other readings of its pose (from the same anchor), and
/// at least 1. With the arithmetic mean two blunders in one pose would hide each other; with the
/// smallest of the others, the target that a missing effect moves most would look like a blunder.
std::vector<double> pose_variances(const Campaign& campaign, const std::vector<double>& norms,
                                   int dimension);

/// The law with these variances, whose bound is 9 times their 0.9 quantile: a pose counts in full
/// up to three times the deviation of nine poses of ten. If more are off, the model lacks
/// something.
ReadingLaw bounded_law(double degrees_of_freedom, std::vector<double> variance);

/// Sigma and distribution of the residuals of a fit.
struct ResidualDescription {
  ReadingSigma sigma;
  ReadingLaw law;
};

/// The law and the sigma with the maximum likelihood. `norms`: squared norms of position and
/// orientation of each row, not whitened [m^2, rad^2]. Student's t with 2 to 30 degrees of freedom
/// is taken if its log-likelihood exceeds that of the Gaussian law by more than log(rows) / 2, the
/// BIC charge of its one parameter. Sigma is found by expectation-maximisation: with m = 3 or 1
/// numbers per row,
///     sigma^2 = correction / (m rows) sum_i weight_i / v_i |r_i|^2,
/// repeated until convergence. `correction`: equations / degrees of freedom, of each kind. `robust`
/// false: always Gaussian.
ResidualDescription describe_residuals(const std::vector<Eigen::Vector2d>& norms,
                                       const Campaign& campaign, const ReadingSigma& start,
                                       const Eigen::Array2d& correction, bool robust);

/// Sigma if there are hardly more readings than unknowns. Prior: u = ln(sigma / expected) is normal
/// with deviation 2, and those of position and orientation have the correlation rho, because what a
/// model lacks moves both. Without it, one sigma could go to zero while the other takes all the
/// misfit. With S the sum of squares (estimate sigma^2 f with f degrees of freedom),
///     S / sigma^2 = f + (u - rho u of the other) / (4 (1 - rho^2)).
/// With many degrees of freedom it changes nothing.
ReadingSigma sigma_with_prior(const ReadingSigma& sigma, const Eigen::Array2d& freedom,
                              const ReadingSigma& expected, bool has_orientation);

/// Sigma from the medians of the squared norms [m^2, rad^2], consistent for a Gaussian law. Throws
/// std::invalid_argument if there are none.
ReadingSigma median_sigma(const std::vector<Eigen::Vector2d>& norms, const ReadingSize& size);

/// pose_variances() of norms that are not yet whitened.
std::vector<double> pose_variances(const std::vector<Eigen::Vector2d>& norms,
                                   const Campaign& campaign, const ReadingSigma& sigma);

/// Whether two sigmas differ by 1 % at most.
bool is_close(const ReadingSigma& a, const ReadingSigma& b);

}  // namespace armtrue
