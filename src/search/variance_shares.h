#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "search/linearization.h"

namespace armtrue {

/// Share of each group of columns in the sum of squares that all groups together explain (least
/// squares): the gain beside those that entered before it, averaged over the orders of entry
/// (Lindeman, Merenda, Gold 1980; Shapley's value).
struct VarianceShares {
  std::vector<double> of_group;  ///< not negative, sum 1; all 0 if nothing is explained
  /// poses x groups: derivative of each share with respect to the weight of a pose.
  Eigen::MatrixXd influence;

  /// Standard deviation of the sum of `weights` times shares, clustered by pose (infinitesimal
  /// jackknife, Jaeckel 1972).
  double standard_deviation(const Eigen::VectorXd& weights) const;
};

/// Over all orders for up to five groups, else over orders drawn from `seed`, each with its
/// reverse.
VarianceShares variance_shares(const BesideTheRest& beside, std::uint64_t seed);

}  // namespace armtrue
