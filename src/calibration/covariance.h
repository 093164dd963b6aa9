#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "armtrue/observation/session_models.h"
#include "calibration/prior.h"
#include "linear_algebra/sparse_cholesky.h"

namespace armtrue {

/// Where each pose gives one number, no readings share an error. With h the leverage of a pose, CR3
/// makes its variance 1 / (1 - h) times too large. CR2 then replaces CR3: it has no bias for
/// independent errors of equal variance. The factors multiply the variances: intervals are those of
/// Student's t with poses - 1 degrees of freedom, and a standard deviation that is known from n of
/// them needs (t_0.975(n) / t_0.975(poses - 1))^2 (Bell, McCaffrey 2002).
struct SingleNumbers {
  /// n = numbers minus the unknowns that they determine.
  double of_readings = 1;
  /// Of each prior. n of a width that is estimated: the number of its unknowns that the readings
  /// determine, and 1 / (2 log_spread^2) for its own prior.
  std::vector<double> of_priors;
};

/// Nothing if a pose gives several numbers. `share_of_readings`: see CalibrationResult. `freedom`:
/// numbers minus those that are determined.
std::optional<SingleNumbers> single_numbers(const SessionModels& models, const Priors& priors,
                                            const Eigen::VectorXd& share_of_readings,
                                            double freedom);

/// Covariance of the unknowns, clustered by pose, because readings of one pose may share an error
/// (CR3; see influence_of_pose and InfluenceSums):
///     L (S + sum over the priors of l l^T) L^T,
/// L the `root`, S the covariance of the poses in its coordinates, l the row of L of a prior's
/// unknown, divided by the prior's deviation. `variance`: of a whitened reading, for directions
/// that only one pose shows. At most 16384 poses are used, at equal steps, and their covariance is
/// scaled to all. `single`: see single_numbers().
Eigen::MatrixXd covariance_by_pose(const SessionModels& models, const std::vector<Prior>& priors,
                                   const Eigen::VectorXd& x, const std::vector<double>& weights,
                                   double degrees_of_freedom, const Eigen::MatrixXd& root,
                                   double variance, const std::optional<SingleNumbers>& single);
/// The same with a sparse root.
Eigen::MatrixXd covariance_by_pose(const SessionModels& models, const std::vector<Prior>& priors,
                                   const Eigen::VectorXd& x, const std::vector<double>& weights,
                                   double degrees_of_freedom, const SparseRows& root,
                                   double variance, const std::optional<SingleNumbers>& single);

}  // namespace armtrue
