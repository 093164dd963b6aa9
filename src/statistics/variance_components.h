#pragma once

#include <Eigen/Core>
#include <vector>

namespace armtrue {

/// A linear mixed model r = X b + Z u + e, e ~ N(0, s^2 I), as sums of what X does not span: with Q
/// an orthonormal basis of X, Z' = Z - Q Q^T Z and r' likewise.
struct MixedModelSums {
  Eigen::MatrixXd zz;  ///< Z'^T Z', p x p
  Eigen::VectorXd zr;  ///< Z'^T r'
  double rr = 0;       ///< |r'|^2
  double freedom = 0;  ///< number of rows minus rank of X
};

/// Consecutive random effects with one standard deviation tau: u_k ~ N(0, tau^2). Beforehand
/// ln tau ~ N(0, log_spread^2): the columns of Z are scaled so that 1 is usual.
struct VarianceGroup {
  Eigen::Index first = 0, count = 0;
  double log_spread = 1;
};

struct VarianceComponents {
  Eigen::VectorXd tau;   ///< of each group
  double noise = 1;      ///< s
  Eigen::VectorXd mean;  ///< of u, given r: the best linear unbiased prediction
  /// How many of the numbers u the readings determine: sum of 1 - var(u | r) / tau^2.
  double determined = 0;
  /// Twice the rise of the restricted log likelihood over that of u = 0.
  double gain = 0;
};

/// Restricted maximum likelihood of tau and s under the priors of tau (Patterson, Thompson 1971;
/// MacKay 1992), and the posterior mean of u with these. `start`: tau to start from; 1 if empty.
/// Each step costs a Cholesky factor and an inverse of p x p.
VarianceComponents restricted_likelihood(const MixedModelSums& sums,
                                         const std::vector<VarianceGroup>& groups,
                                         const Eigen::VectorXd& start = {});

}  // namespace armtrue
