#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/prior.h"
#include "calibration/session_models.h"
#include "linear_algebra/sparse_cholesky.h"

namespace armtrue {

/// Covariance of the unknowns, clustered by pose, because readings of one pose may share an error
/// (CR3; see influence_of_pose and InfluenceSums):
///     L (S + sum over the priors of l l^T) L^T,
/// L the `root`, S the covariance of the poses in its coordinates, l the row of L of a prior's
/// unknown, divided by the prior's deviation. `variance`: of a whitened reading, for directions
/// that only one pose shows. At most 16384 poses are used, drawn evenly, and their covariance is
/// scaled to all.
Eigen::MatrixXd covariance_by_pose(const SessionModels& models, const std::vector<Prior>& priors,
                                   const Eigen::VectorXd& x, const std::vector<double>& weights,
                                   double degrees_of_freedom, const Eigen::MatrixXd& root,
                                   double variance);
/// The same with a root of which most numbers are zero.
Eigen::MatrixXd covariance_by_pose(const SessionModels& models, const std::vector<Prior>& priors,
                                   const Eigen::VectorXd& x, const std::vector<double>& weights,
                                   double degrees_of_freedom, const SparseRows& root,
                                   double variance);

}  // namespace armtrue
