#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "search/linearization.h"

namespace armtrue {

/// Of what groups of columns together explain of readings by least squares, the share of each:
/// what it adds to those that entered before it, averaged over the orders of entry (Lindeman,
/// Merenda, Gold 1980; Shapley's value).
struct VarianceShares {
  std::vector<double> of_group;  ///< not negative, sum 1; all 0 where nothing is explained
  /// poses x groups: derivative of each share with respect to the weight of a pose.
  Eigen::MatrixXd influence;

  /// Of the sum of `weights` times shares, clustered by pose (infinitesimal jackknife of Jaeckel
  /// 1972).
  double standard_deviation(const Eigen::VectorXd& weights) const;
};

/// Over all orders for up to five groups, else over orders drawn from `seed`, each with its
/// reverse.
VarianceShares variance_shares(const BesideTheRest& beside, std::uint64_t seed);

}  // namespace armtrue
