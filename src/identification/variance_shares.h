#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace armtrue {

/// Of what groups of columns together explain of `response` by least squares, the share of each:
/// what it adds to those that entered before it, averaged over the orders of entry (Lindeman,
/// Merenda, Gold 1980; Shapley's value). The shares are not negative and sum to 1; all are 0 where
/// nothing is explained. Over all orders for up to eight groups, else over orders drawn from
/// `seed`, each with its reverse.
std::vector<double> variance_shares(const std::vector<Eigen::MatrixXd>& groups,
                                    const Eigen::VectorXd& response, std::uint64_t seed);

}  // namespace armtrue
